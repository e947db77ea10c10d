# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Nothing is compared where nobody knows which of two materials is seen."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.robust_residual import make_comparers, Reach
from diffcal_ros.diagnosis.patches.boundary_strip import BoundaryStrip, knows_boundary
from diffcal_ros.diagnosis.patches.make_evaluator import make_patch_evaluator
from diffcal_ros.scene.model import Scene
import numpy as np
import pytest
from support.scenes import beam_scene
from support.watched import watched, with_step

REACH = Reach(depth=0.06, edge_depth=0.09, edge_pixels=60)
# Half of the median edge of the beam's elements, and a pixel at the body, are known to this [m].
ROUNDING = 1e-9


def _model(scene: Scene, observation) -> ForwardModel:
    return ForwardModel(scene, [observation], make_parameters(scene, ('youngs_modulus',)))


@pytest.fixture(scope='module')
def parted():
    scene = beam_scene((8, 2, 2), region_count=2)
    return _model(scene, watched(seed=5))


def test_what_is_left_out_is_as_far_from_the_border_as_half_an_element(parted):
    comparers = make_comparers(parted)
    strip = BoundaryStrip(parted, comparers)
    view = parted.views(parted.parameters.start())[0]
    depth = comparers[0].compare(view, REACH).depth
    clear = strip.without(0, view, depth)

    # By another route: every pixel of the border itself, lifted to the body, beside every pixel.
    body = parted.body(parted.observations[0]).mesh
    edges, _ = body.edges
    size = np.median(np.linalg.norm(np.diff(body.rest_positions[edges], axis=1)[:, 0], axis=1))
    tracer = view.tracer
    first, second = tracer.edge_faces.T
    beyond = comparers[0].surface.is_second
    border = tracer.edge_vertices[beyond[first] != beyond[second]]
    ends = view.points[border]
    rays = tracer.camera.rays()[depth.pixels[:, 1], depth.pixels[:, 0]]
    seen = rays * view.trace.depth.ravel()[depth.indices][:, None]
    distances = np.min([_to_segment(seen, *pair) for pair in ends], axis=0)
    # The strip is made of points a quarter of an edge apart: an eighth may be missing along it.
    longest = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max()
    assert (distances[~clear] <= 0.5 * size + ROUNDING).all()
    assert (distances[clear] >= 0.5 * size - longest / 8.0).all()
    assert 0.02 < (~clear).mean() < 0.5


def test_a_body_of_one_material_is_compared_everywhere():
    """Whatever a scene would take for the border of two materials, by default its middle."""
    scene, seen = beam_scene((8, 2, 2)), watched(seed=5)
    stated = replace(scene, effects={'depth_bias_by_region': {'at': 0.5}})
    assert (knows_boundary(scene), knows_boundary(stated)) == (False, True)
    assert _compared_pixels(_model(scene, seen)) > 1.05 * _compared_pixels(_model(stated, seen))


def test_a_border_that_is_a_little_off_makes_no_patch_strange():
    """The camera's step begins a third of an element beyond the model's border."""
    known = replace(
        beam_scene((8, 2, 2)),
        effects={'depth_bias_by_region': {'bias': 0.02, 'at': 0.5}},
    )
    seen = with_step(watched(seed=5), 0.5 + 1.0 / 24.0, 0.02, counts=(24, 2, 2))
    model = _model(known, seen)
    evaluator = make_patch_evaluator(model, _start(model))
    assert not evaluator.left_out
    assert all(np.abs(g.patches.values).max() < 0.003 for g in evaluator.groups(_start(model)))


def test_of_a_narrow_band_three_quarters_are_compared():
    """Half an element is as wide as all of it."""
    narrow = {'at': 0.4, 'until': 0.46}
    scene = replace(beam_scene((8, 2, 2)), effects={'depth_bias_by_region': narrow})
    model = _model(scene, watched(seed=5))
    comparers = make_comparers(model)
    view = model.views(_start(model))[0]
    depth = comparers[0].compare(view, REACH).depth
    clear = BoundaryStrip(model, comparers).without(0, view, depth)
    shares = comparers[0].shares(view.trace, depth.indices)
    inside = (shares > 0.4) & (shares < 0.46)
    assert inside.sum() > 100
    assert clear[inside].mean() == pytest.approx(0.75, abs=0.04)
    near = np.minimum(np.abs(shares - 0.4), np.abs(shares - 0.46)) < 0.06 / 8
    np.testing.assert_array_equal(clear, ~near)


def _start(model: ForwardModel) -> np.ndarray:
    return model.parameters.start()


def _compared_pixels(model: ForwardModel) -> float:
    evaluator = make_patch_evaluator(model, _start(model))
    groups = evaluator.groups(_start(model))
    return sum(group.patches.weights.sum() for group in groups if group.kind == 'depth')


def _to_segment(points: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    along = second - first
    share = np.clip((points - first) @ along / (along @ along), 0.0, 1.0)
    return np.linalg.norm(points - first - share[:, None] * along, axis=1)
