# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.depth.ray_reference import trace_rays
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer, OutOfViewError
import numpy as np
import pytest
from support.beams import beam_mesh
from support.views import bent_beam, CAMERA, tilted_view

# The reference casts rays in single precision: 0.4 m, a few roundings.
_SINGLE = 2e-6


def _tracer(triangles: np.ndarray, points: np.ndarray) -> DepthTracer:
    return DepthTracer(triangles, len(points), CAMERA)


def test_depth_agrees_with_the_ray_tracer() -> None:
    points, triangles = bent_beam()
    seen = tilted_view(points)
    depth = _tracer(triangles, points).trace(seen).full_depth()
    reference = trace_rays(seen, triangles, CAMERA)
    both = np.isfinite(depth) & np.isfinite(reference)
    # Pixel centres within rounding of an edge may fall to either side.
    assert (np.isfinite(depth) != np.isfinite(reference)).sum() <= 2
    close = np.abs(depth[both] - reference[both]) < _SINGLE
    assert (~close).sum() <= 2
    assert both.sum() > 2000


def test_nothing_is_lost_where_neighbours_share_an_edge_on_pixel_centres() -> None:
    # A wall facing the camera whose edges all run through pixel centres.
    side = 8
    rows, columns = np.mgrid[: side + 1, : side + 1]
    u, v = 20.0 + 5.0 * columns, 16.0 + 5.0 * rows
    points = np.stack(
        [
            (u - CAMERA.cx) / CAMERA.fx * 0.5,
            (v - CAMERA.cy) / CAMERA.fy * 0.5,
            np.full(u.shape, 0.5),
        ],
        axis=-1,
    ).reshape(-1, 3)
    corner = (rows[:-1, :-1] * (side + 1) + columns[:-1, :-1]).ravel()
    triangles = np.concatenate(
        [
            np.stack([corner, corner + side + 1, corner + side + 2], axis=1),
            np.stack([corner, corner + side + 2, corner + 1], axis=1),
        ]
    ).astype(np.int32)
    trace = _tracer(triangles, points).trace(points)
    # Rounding of the test's own points may drop pixels of the wall's border, none inside.
    assert (trace.faces >= 0).sum() >= (5 * side - 1) ** 2
    assert (trace.faces[2:-2, 2:-2] >= 0).all()
    np.testing.assert_allclose(trace.depth[trace.faces >= 0], 0.5)


def test_a_body_partly_out_of_view_is_cut_at_the_border() -> None:
    points, triangles = bent_beam()
    seen = tilted_view(points) + np.array([0.16, 0.0, 0.0])
    depth = _tracer(triangles, points).trace(seen).full_depth()
    reference = trace_rays(seen, triangles, CAMERA)
    assert (np.isfinite(depth) != np.isfinite(reference)).sum() <= 2
    assert np.isfinite(depth[:, -1]).any()


def test_outline_runs_around_the_body_once() -> None:
    mesh = beam_mesh()
    points = tilted_view(mesh.rest_positions - mesh.rest_positions.mean(axis=0))
    trace = _tracer(mesh.surface_triangles, points).trace(points)
    outline = trace.outline
    # A convex body: closed outline (normals times lengths cancel), nothing of it behind.
    np.testing.assert_allclose(outline.lengths @ outline.normals, 0.0, atol=1e-9)
    assert np.isnan(outline.behind).all()
    # Green's theorem: the outline encloses as many pixels as see the body.
    area = 0.5 * (outline.lengths * (outline.points[:, :2] * outline.normals).sum(axis=1)).sum()
    seen = (trace.faces >= 0).sum()
    assert area == pytest.approx(seen, abs=0.02 * seen)


def test_outline_sees_what_lies_behind_itself() -> None:
    points, triangles = bent_beam(turn=7.0)
    seen = tilted_view(points)
    outline = _tracer(triangles, points).trace(seen).outline
    hiding = np.isfinite(outline.behind)
    assert hiding.any()
    assert (outline.behind[hiding] > outline.points[hiding, 2]).all()
    assert (~hiding).any()


@pytest.mark.parametrize(
    ('shift', 'message'),
    [((0.0, 0.0, -0.5), 'must lie in front of it'), ((1.0, 0.0, 0.0), "camera's view")],
)
def test_a_body_out_of_view_is_refused(shift, message: str) -> None:
    points, triangles = bent_beam()
    with pytest.raises(OutOfViewError, match=message):
        _tracer(triangles, points).trace(tilted_view(points) + shift)


def test_a_trace_does_not_depend_on_what_its_tracer_traces_later() -> None:
    points, triangles = bent_beam()
    tracer = _tracer(triangles, points)
    here, elsewhere = tilted_view(points), tilted_view(points, 0.5)
    alone = tracer.trace(here)
    expected = (alone.full_depth(), alone.outline.points, _derivatives(alone))
    first = tracer.trace(here)
    second = tracer.trace(elsewhere)
    assert second.outline.points.shape != expected[1].shape
    _derivatives(second)
    np.testing.assert_array_equal(first.full_depth(), expected[0])
    np.testing.assert_array_equal(first.outline.points, expected[1])
    np.testing.assert_allclose(_derivatives(first), expected[2], rtol=1e-12)


def _derivatives(trace: Trace) -> np.ndarray:
    """Return what area averages of every pixel give by the vertices."""
    area = trace.area_image(side=4)
    weights = np.random.default_rng(3).random(trace.shape)
    return area.pull_back(weights)
