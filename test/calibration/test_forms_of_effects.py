# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects in other forms than the library's: tangents by differences, stated and fitted alike."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.form_parameters import form_parameters
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.robust_residual import make_comparers
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.effects.site import SeenPixels
from diffcal_ros.scene.model import Scene
import numpy as np
import pytest
from support.scenes import beam_scene, CAMERA, observation, true_depth

_WITH_FORMS = [name for name, effect in EFFECTS.items() if effect.forms]
_READING = ['depth_affine', 'depth_bias_by_region']
_MOVING = [name for name in _WITH_FORMS if name not in _READING]
# Where fits of the effect may be, of sizes that matter: SI units.
_HERE = {
    'camera_offset': {'rigid_offset.x': 0.004, 'rigid_offset.ry': 0.05},
    'contact_plane': {'contact_plane.height': -0.056},
    'rest_curvature': {'rest_curvature.a': 0.8, 'rest_curvature.b': -0.6},
    'added_mass': {'added_mass.mass': 0.012},
    'stiffness_contrast': {'stiffness_contrast.along': 0.3},
    'depth_affine': {'depth_affine.scale': 0.02, 'depth_affine.bias': -0.003},
    'depth_bias_by_region': {'depth_bias_by_region.bias': 0.004},
}


def _model(scene: Scene, effect: str) -> tuple[ForwardModel, np.ndarray]:
    """Return a model with an effect and all of its forms, and coordinates away from zero."""
    own = EFFECTS[effect]
    known = make_parameters(scene, ('youngs_modulus', own.fit_name), with_edge_bias=False)
    parameters = ParameterSet((*known.parameters, *form_parameters(own, 1.0)))
    model = ForwardModel(scene, [observation(true_depth())], parameters)
    here = parameters.start()
    for place, parameter in enumerate(parameters):
        here[place] = _HERE[effect].get(parameter.name, here[place])
        if parameter.is_freed:
            size = 0.2 if effect == 'contact_plane' else 1.0
            here[place] = size * (0.2, -0.3, 0.1, 0.25, -0.15)[place % 5] * parameter.part.scale
    return model, here


@pytest.mark.parametrize('effect', _MOVING)
def test_points_follow_the_form(effect):
    model, here = _model(beam_scene((4, 1, 1)), effect)
    tangents = model.tangents(here)[0]
    weights = 1.0 + (np.arange(tangents[0].size).reshape(tangents[0].shape) % 7)
    by_adjoint = model.pull_back([weights], here)
    np.testing.assert_allclose(by_adjoint, (tangents * weights).sum(axis=(1, 2)), rtol=1e-6)
    moving = 0
    for place, parameter in enumerate(model.parameters):
        if np.abs(tangents[place]).max() == 0.0:
            continue  # Nothing touches there.
        moving += parameter.is_freed
        usual = 1.0 if parameter.component is None else parameter.component.scale
        errors = []
        for step in (0.008 * usual, 0.004 * usual, 0.002 * usual):
            moved = np.zeros(len(here))
            moved[place] = step
            ahead, behind = (model.views(here + sign * moved)[0].points for sign in (1.0, -1.0))
            slope = (ahead - behind) / (2.0 * step)
            errors.append(
                np.linalg.norm(slope - tangents[place]) / np.linalg.norm(tangents[place])
            )
        assert min(errors) < 2e-3, (parameter.name, errors)
        assert errors[-1] < 0.01, (parameter.name, errors)
    # A plane is touched in few places.
    assert moving == (1 if effect == 'contact_plane' else len(EFFECTS[effect].forms))


@pytest.mark.parametrize('effect', _WITH_FORMS)
def test_a_form_that_a_scene_states_is_the_fitted_one(effect):
    scene = beam_scene((6, 2, 2))
    fitted, here = _model(scene, effect)
    stated = replace(scene, effects={effect: dict(fitted.effects.amplitudes(here)[effect])})
    if effect == 'camera_offset':
        values = dict(zip(fitted.parameters.names, here.tolist(), strict=True))
        offset = {axis: values[f'rigid_offset.{axis}'] for axis in ('x', 'ry')}
        stated.effects[effect].update(offset)
    plain = make_parameters(stated, ('youngs_modulus',), with_edge_bias=False)
    other = ForwardModel(stated, fitted.observations, plain)
    there = here[: len(plain)]
    np.testing.assert_allclose(
        other.views(there)[0].points, fitted.views(here)[0].points, atol=1e-9
    )
    assert other.sensor(there, 0) == fitted.sensor(here, 0)


@pytest.mark.parametrize('effect', _READING)
@pytest.mark.slow_but_first
def test_depth_follows_an_error_that_differs_from_place_to_place(effect):
    model, here = _model(beam_scene((6, 2, 2)), effect)
    objective = RobustObjective(model)
    tangent = model.tangents(here)[0]
    comparison, view = objective.comparisons(here)[0], model.views(here)[0]
    _, jacobian = objective.with_jacobians(0, comparison, view, tangent, here)[0]
    places = comparison.depth.indices
    own = [p for p, one in enumerate(model.parameters) if one.effect == effect]
    # Without an edge in the picture nothing is beyond it.
    known = EFFECTS[effect]
    assert len(own) == len(known.components_in({})) + len(known.forms)
    for place in own:
        moved = here.copy()
        moved[place] += 1e-4
        change = objective.comparisons(moved)[0].difference - comparison.difference
        np.testing.assert_allclose(-change.ravel()[places], 1e-4 * jacobian[:, place], atol=1e-12)


def test_an_error_over_the_picture_is_a_polynomial_of_the_direction_it_is_seen_in():
    scene, effect = beam_scene((6, 2, 2)), EFFECTS['depth_affine']
    amounts = {'bias': 0.002, 'x': -0.015, 'y': 0.01, 'xy': 0.04, 'yy': -0.03, 'xxy': 0.2}
    model = ForwardModel(
        replace(scene, effects={'depth_affine': amounts}),
        [observation(true_depth())],
        make_parameters(scene, ('youngs_modulus',), with_edge_bias=False),
    )
    here = model.parameters.start()
    trace, sensor = model.views(here)[0].trace, model.sensor(here, 0)
    read = make_comparers(model)[0].read(trace, sensor)
    rays = CAMERA.rays()[trace.rows, trace.columns]
    x, y = rays[..., 0], rays[..., 1]
    expected = 0.002 - 0.015 * x + 0.01 * y + 0.04 * x * y - 0.03 * y**2 + 0.2 * x**2 * y
    np.testing.assert_allclose(read - trace.depth, np.where(trace.faces < 0, np.nan, expected))
    # At the edge of a usual picture, and at 60 degrees, each usual amount is a usual bias.
    directions, facing = np.full((1, 2), 0.3), np.cos(np.deg2rad([60.0]))
    edge = SeenPixels(np.ones(1), np.zeros(1, dtype=bool), directions=directions, facing=facing)
    for part in effect.forms:
        size = 1.0 if part.name.startswith('spot') else effect.depth_error_mode(part.name, edge)
        np.testing.assert_allclose(part.scale * size, 0.005, rtol=1e-12)


def test_errors_of_all_spots_are_an_error_of_all_and_each_is_largest_in_one_place(random):
    effect = EFFECTS['depth_affine']
    names = [part.name for part in effect.forms if part.name.startswith('spot')]
    directions = random.uniform(-0.7, 0.7, size=(300, 2))
    # The eighth of seven in a row begins the second row.
    directions[0] = (-0.45, -0.15)
    seen = SeenPixels(np.ones(300), np.zeros(300, dtype=bool), directions=directions)
    errors = np.array([effect.depth_error_mode(name, seen) for name in names])
    np.testing.assert_allclose(errors.sum(axis=0), 1.0)
    assert errors.min() >= 0.0
    np.testing.assert_allclose(errors[:, 0], np.eye(len(names))[names.index('spot_8')])
    # No more than four places have to do with a pixel.
    assert (errors > 0.0).sum(axis=0).max() == 4


def test_an_error_by_angle_is_that_of_the_surface_that_the_depths_show():
    scene = beam_scene((6, 2, 2))
    model = ForwardModel(
        replace(scene, effects={'depth_affine': {'aslant': 0.01, 'aslant_2': -0.02}}),
        [observation(true_depth())],
        make_parameters(scene, ('youngs_modulus',), with_edge_bias=False),
    )
    here = model.parameters.start()
    trace, sensor = model.views(here)[0].trace, model.sensor(here, 0)
    error = make_comparers(model)[0].read(trace, sensor) - trace.depth
    rays = CAMERA.rays()[trace.rows, trace.columns]
    points = rays * trace.depth[..., None]
    # By the points of neighbouring pixels of one triangle, whatever its corners are.
    normals = np.cross(points[1:-1, 2:] - points[1:-1, :-2], points[2:, 1:-1] - points[:-2, 1:-1])
    own = trace.faces[1:-1, 1:-1]
    around = [trace.faces[1:-1, 2:], trace.faces[1:-1, :-2]]
    around += [trace.faces[2:, 1:-1], trace.faces[:-2, 1:-1]]
    inside = (own >= 0) & np.all([other == own for other in around], axis=0)
    towards = rays[1:-1, 1:-1]
    lengths = np.linalg.norm(normals, axis=-1) * np.linalg.norm(towards, axis=-1)
    aslant = 1.0 - np.abs((normals * towards).sum(axis=-1)[inside]) / lengths[inside]
    # From one triangle's middle to its corners the ray turns by half a degree.
    np.testing.assert_allclose(
        error[1:-1, 1:-1][inside], 0.01 * aslant - 0.02 * aslant**2, atol=2e-4
    )
    assert np.ptp(aslant) > 0.1


def test_errors_of_all_places_are_an_error_of_all_and_none_of_a_fixture(random):
    effect = EFFECTS['depth_bias_by_region']
    places = random.uniform(-1.0, 1.0, size=(200, 3))
    places[:, 0] = np.abs(places[:, 0])
    sides = random.uniform(-1.0, 1.0, size=(200, 2))
    seen = SeenPixels(np.ones(200), np.zeros(200, dtype=bool), sides=sides, locate=lambda: places)

    def whole(way: str) -> np.ndarray:
        names = [part.name for part in effect.forms if part.name.rpartition('_')[0] == way]
        total: np.ndarray = np.sum([effect.depth_error_mode(name, seen) for name in names], axis=0)
        return total

    np.testing.assert_allclose(whole('all'), 1.0)
    np.testing.assert_allclose(whole('a'), places[:, 1])
    np.testing.assert_allclose(np.sign(whole('side_b')), np.sign(places[:, 2]))
    assert np.abs(whole('side_b')).max() == pytest.approx(1.0)
    np.testing.assert_allclose(whole('facing_a'), sides[:, 0])
    np.testing.assert_allclose(whole('facing_b'), sides[:, 1])
    fixture = SeenPixels(seen.depth, seen.is_second)
    assert not any(effect.depth_error_mode(p.name, fixture).any() for p in effect.forms)
