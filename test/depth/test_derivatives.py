# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The image's derivative against differences, silhouettes and self-occlusion included.

Differences are taken over steps well under a tenth of a pixel, of images whose outline pixels
are sampled so finely that the differences do not show it; the gradient is the default's. Errors
are held against the gradient's norm: a direction that happens to change nothing has no relative
error of its own.
"""

from diffcal_ros.depth.tracer import DepthTracer, pose_gradient
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from support.views import bent_beam, CAMERA, tilted_view

BACKGROUND = 0.9
# 0.4 m at 200 px: 1e-5 m is 0.005 px.
STEPS = (6e-5, 3e-5, 1.5e-5)
_FINE, _DEFAULT = 128, 8
_RELATIVE = 0.01


@pytest.fixture
def weights(random) -> np.ndarray:
    """A smooth random image: the derivative of some loss by every pixel."""
    noise = random.normal(size=(CAMERA.height, CAMERA.width))
    return 20.0 * gaussian_filter(noise, 4.0)


class _Loss:
    """Weighted sum over the area-averaged image."""

    def __init__(self, turn: float, weights: np.ndarray) -> None:
        points, triangles = bent_beam(turn)
        self.points = tilted_view(points)
        self.weights = weights
        self.tracer = DepthTracer(triangles, len(points), CAMERA)

    def value(self, points: np.ndarray) -> float:
        trace = self.tracer.trace(points)
        image = trace.area_image(side=_FINE, background=BACKGROUND).image
        weights = self.weights[trace.rows, trace.columns]
        # Pixels outside the window keep the background, so only differences from it count.
        return float((weights * (image - BACKGROUND)).sum())

    def gradient(self) -> np.ndarray:
        trace = self.tracer.trace(self.points)
        area = trace.area_image(side=_DEFAULT, background=BACKGROUND)
        return area.pull_back(self.weights[trace.rows, trace.columns])

    def slope(self, direction: np.ndarray, step: float) -> float:
        above = self.value(self.points + step * direction)
        below = self.value(self.points - step * direction)
        return (above - below) / (2.0 * step)


def _smooth_directions(points: np.ndarray, random) -> list[np.ndarray]:
    """Displacements that vary over the body's length, as a body's do."""
    directions = []
    for _ in range(4):
        wave = np.sin(points @ random.normal(size=(3, 3)) * 20.0 + random.normal(size=3))
        directions.append(wave / np.abs(wave).max())
    return directions


@pytest.mark.parametrize('turn', [2.0, 7.0], ids=['plain', 'self-occluded'])
@pytest.mark.parametrize('step', STEPS)
def test_gradient_by_the_vertices(turn, step, weights, random) -> None:
    loss = _Loss(turn, weights)
    gradient = loss.gradient()
    scale = np.linalg.norm(gradient)
    for direction in _smooth_directions(loss.points, random):
        expected = float((gradient * direction).sum())
        error = abs(loss.slope(direction, step) - expected)
        assert error < _RELATIVE * scale


@pytest.mark.parametrize('turn', [2.0, 7.0], ids=['plain', 'self-occluded'])
@pytest.mark.parametrize('step', STEPS)
def test_gradient_by_the_pose(turn, step, weights) -> None:
    loss = _Loss(turn, weights)
    by_pose = pose_gradient(loss.points, loss.gradient())
    scale = np.linalg.norm(by_pose[:3])
    for axis in range(3):
        shift = np.zeros(3)
        shift[axis] = 1.0
        slope = loss.slope(np.broadcast_to(shift, loss.points.shape), step)
        assert abs(slope - by_pose[axis]) < _RELATIVE * scale
    spread = np.linalg.norm(by_pose[3:])
    for axis in range(3):
        vector = np.zeros(3)
        vector[axis] = step / 0.3
        above = loss.value(loss.points @ rotation_matrix(vector).T)
        below = loss.value(loss.points @ rotation_matrix(-vector).T)
        slope = (above - below) / (2.0 * vector[axis])
        assert abs(slope - by_pose[3 + axis]) < _RELATIVE * spread


def test_without_the_outline_the_gradient_would_be_wrong(weights, random) -> None:
    # What a renderer without silhouette derivatives would give: the test above can fail.
    loss = _Loss(2.0, weights)
    trace = loss.tracer.trace(loss.points)
    pixels = np.flatnonzero(trace.faces.ravel() >= 0).astype(np.int32)
    direction = np.broadcast_to([1.0, 0.3, 0.0], loss.points.shape)
    inside = trace.push_depth(pixels, direction[None])[:, 0]
    seen = loss.weights[trace.rows, trace.columns].ravel()[pixels]
    slope = loss.slope(direction, STEPS[1])
    assert abs(float(seen @ inside) - slope) > 0.3 * abs(slope)


@pytest.mark.parametrize('turn', [2.0, 7.0], ids=['plain', 'self-occluded'])
def test_forward_and_backward_agree(turn, weights, random) -> None:
    loss = _Loss(turn, weights)
    directions = np.stack(_smooth_directions(loss.points, random))
    gradient = loss.gradient()
    trace = loss.tracer.trace(loss.points)
    rates = trace.area_image(side=_DEFAULT, background=BACKGROUND).push_forward(directions)
    pushed = np.einsum('hwk,hw->k', rates, weights[trace.rows, trace.columns])
    pulled = np.einsum('kni,ni->k', directions, gradient)
    np.testing.assert_allclose(pushed, pulled, rtol=1e-9, atol=1e-9 * np.abs(pulled).max())


@pytest.mark.parametrize('step', STEPS)
def test_depth_at_pixel_centres_follows_the_surface(step, random) -> None:
    points, triangles = bent_beam()
    seen = tilted_view(points)
    tracer = DepthTracer(triangles, len(points), CAMERA)
    direction = _smooth_directions(seen, random)[0]
    trace = tracer.trace(seen)
    faces, depth_faces = trace.full_depth(), trace.faces
    pixels = np.flatnonzero(depth_faces.ravel() >= 0).astype(np.int32)
    rates = np.full(trace.shape, np.nan)
    rates.ravel()[pixels] = trace.push_depth(pixels, direction[None])[:, 0]
    full = np.full(faces.shape, np.nan)
    full[trace.rows, trace.columns] = rates
    above = tracer.trace(seen + step * direction).full_depth()
    below = tracer.trace(seen - step * direction).full_depth()
    slope = (above - below) / (2.0 * step)
    # A pixel that changes over to a neighbouring triangle bends by the crease between them, and
    # one at the outline jumps: both are few.
    both = np.isfinite(slope) & np.isfinite(full)
    wrong = np.abs(slope[both] - full[both]) > 1e-3 * np.abs(full[both]).max()
    assert wrong.mean() < 0.03


def test_outline_moves_as_its_edges_do(random) -> None:
    points, triangles = bent_beam()
    seen = tilted_view(points)
    tracer = DepthTracer(triangles, len(points), CAMERA)
    direction = _smooth_directions(seen, random)[1]
    trace = tracer.trace(seen)
    outline = trace.outline
    rates = trace.push_outline(outline.segments, direction[None])[:, 0]
    ends = tracer.edge_vertices[outline.edges]

    def beside(moved: np.ndarray) -> np.ndarray:
        """How far each segment's edge lies beyond the segment's first place [px]."""
        a, b = (CAMERA.project(moved[ends[:, k]]) for k in range(2))
        here = outline.points[:, :2]
        tangent = b - a
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-12)
        away = a - here
        away -= (away * tangent).sum(axis=1, keepdims=True) * tangent
        return (away * outline.normals).sum(axis=1)

    step = 1e-6
    slope = (beside(seen + step * direction) - beside(seen - step * direction)) / (2.0 * step)
    np.testing.assert_allclose(rates, slope, atol=1e-4 * np.abs(slope).max())


def test_a_body_cut_by_the_border_moves_no_pixel_elsewhere() -> None:
    points, triangles = bent_beam()
    seen = tilted_view(points) + np.array([-0.145, 0.0, 0.0])
    trace = DepthTracer(triangles, len(points), CAMERA).trace(seen)
    segments = trace.segments
    outside = segments.points.numpy()[:, 0] < -0.5
    assert (outside & (segments.lengths.numpy() > 0.0)).any()
    area = trace.area_image(background=BACKGROUND)
    # The window ends a pixel beyond the body on the right.
    weights = np.zeros(trace.shape)
    weights[:, -1] = 1.0
    assert not area.pull_back(weights).any()
    shift = np.broadcast_to(np.array([1.0, 0.0, 0.0]), (1, *seen.shape))
    assert not area.push_forward(shift)[:, -1].any()
