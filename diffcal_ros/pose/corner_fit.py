# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit one pose to the corners of many views, outliers weighted down, depth beside them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
from diffcal_ros.least_squares.normal_equations import NormalEquations
from diffcal_ros.least_squares.residual_channel import equations, ResidualChannel, Weights
from diffcal_ros.median_spread import median_spread
from diffcal_ros.pose.detection import Detection
from diffcal_ros.pose.marker_depth import MarkerPoints
from diffcal_ros.pose.target import Target
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_ROUNDS = 50
_UNBOUNDED = np.full(6, -np.inf), np.full(6, np.inf)
_SMALL_STEP = 1e-8  # Metres and radians alike.
# A sighting this many times as far off as the median one counts a quarter (Geman-McClure).
_OUTLIER = 3.0
_FINEST_SCALE = 0.05  # Corners are no better than this [px].
USED = 0.25  # Sightings of less weight are outliers.
# Pixels on a marker share their error (infrared ink contrast, local bias): together they count
# as this many independent ones of this standard deviation [m].
_DEPTH_COUNT = 10.0
_DEPTH_ERROR = 1e-3


@dataclass(frozen=True)
class Sightings:
    """Parts of a target, each as one frame saw it: a marker's k = 4 corners, or one of a board.

    Attributes:
        points: corners in the target's frame [m], shape (s, k, 3).
        pixels: the same in the ideal pinhole image [px], shape (s, k, 2).
        frames: number of the frame, shape (s,).
        ids: numbers of the parts, shape (s,).
    """

    points: FloatArray
    pixels: FloatArray
    frames: IntArray
    ids: IntArray

    @property
    def size(self) -> int:
        """Number of corners in one sighting."""
        return self.points.shape[1]

    @cached_property
    def part_count(self) -> int:
        """Number of different parts."""
        return len(np.unique(self.ids))

    def errors(self, camera_from_marker: FloatArray, camera: PinholeCamera) -> FloatArray:
        """Return each sighting's root mean square corner distance [px], shape (s,)."""
        miss = camera.project(apply(camera_from_marker, self.points)) - self.pixels
        errors: FloatArray = np.sqrt((miss**2).sum(axis=-1).mean(axis=-1))
        return errors

    def of_frame(self, frame: int) -> 'Sightings':
        """Return the sightings of one frame."""
        kept = self.frames == frame
        return Sightings(self.points[kept], self.pixels[kept], self.frames[kept], self.ids[kept])

    def averaged(self, weights: FloatArray) -> 'Sightings':
        """Return one sighting per part: the weighted mean over all frames.

        Parts that only outliers show are left out, unless there are no others.
        """
        good = weights >= USED
        kept = np.isin(self.ids, self.ids[good if good.any() else slice(None)])
        ids, first, index = np.unique(self.ids[kept], return_index=True, return_inverse=True)
        sums = np.zeros((len(ids), *self.pixels.shape[1:]))
        np.add.at(sums, index, weights[kept, None, None] * self.pixels[kept])
        means = sums / np.bincount(index, weights[kept])[:, None, None]
        return Sightings(self.points[kept][first], means, np.zeros(len(ids), np.int64), ids)


@dataclass(frozen=True)
class CornerFit:
    """A pose fitted to sightings.

    Attributes:
        camera_from_marker: shape (4, 4).
        weights: of the sightings, 1 for good ones, shape (s,).
        error: robust total, for comparing fits with the same scale [px^2].
    """

    camera_from_marker: FloatArray
    weights: FloatArray
    error: float


def gather(detections: Sequence[Detection], target: Target) -> Sightings:
    """List every sighting of the target's parts, frames in the given order."""
    seen = [
        (frame, part, corners)
        for frame, detection in enumerate(detections)
        for part, corners in sorted(detection.corners.items())
    ]
    size = len(next(iter(target.corners.values())))
    return Sightings(
        points=np.array([target.corners[part] for _, part, _ in seen]).reshape(-1, size, 3),
        pixels=np.array([corners for *_, corners in seen]).reshape(-1, size, 2),
        frames=np.array([frame for frame, *_ in seen], dtype=np.int64),
        ids=np.array([part for _, part, _ in seen], dtype=np.int64),
    )


def typical_error(errors: FloatArray) -> float:
    """Return the scale [px] that tells outliers from good sightings."""
    return max(float(np.median(errors)), _FINEST_SCALE)


def fit_corners(
    start: FloatArray,
    sightings: Sightings,
    camera: PinholeCamera,
    *,
    scale: float | None = None,
    corner_error: float = 1.0,
    depth: MarkerPoints | None = None,
) -> CornerFit:
    """Fit one pose to all sightings by damped Gauss-Newton steps.

    Args:
        start: camera_from_marker to start from, shape (4, 4).
        sightings: at least one.
        camera: intrinsics of the ideal pinhole image.
        scale: what counts as a typical error [px]; None takes each round's median.
        corner_error: standard deviation of a mean corner [px]; weighs corners against depth.
        depth: measured points on the markers, or None.
    """
    pose, damping = start, 1e-6
    errors = sightings.errors(pose, camera)
    for _ in range(_ROUNDS):
        used_scale = typical_error(errors) if scale is None else scale
        weights = _weights(errors, used_scale)
        said = pose_equations(
            pose, sightings, camera, weights, corner_error=corner_error, depth=depth
        )
        each = _corner_weights(sightings, weights, corner_error)
        step = np.zeros(6)
        while damping < 1e6:
            step = gauss_newton_step(said, np.zeros(6), *_UNBOUNDED, damping)
            moved = perturbed(pose, step)
            tried = sightings.errors(moved, camera)
            cost = 0.5 * sightings.size * float(each @ tried**2) + _depth_cost(moved, depth)
            if cost <= said.cost:
                pose, errors, damping = moved, tried, max(damping * 0.1, 1e-12)
                break
            damping *= 10.0
        if damping >= 1e6 or np.abs(step).max() < _SMALL_STEP:
            break
    used_scale = typical_error(errors) if scale is None else scale
    weights = _weights(errors, used_scale)
    return CornerFit(pose, weights, float((np.sqrt(weights) * errors**2).sum()))


def perturbed(camera_from_marker: FloatArray, step: FloatArray) -> FloatArray:
    """Shift a pose by step[:3] [m] and turn it about its own origin by step[3:] [rad].

    Both are vectors in the camera's frame.
    """
    return transform(
        rotation_matrix(step[3:]) @ camera_from_marker[:3, :3],
        camera_from_marker[:3, 3] + step[:3],
    )


def pose_equations(
    pose: FloatArray,
    sightings: Sightings,
    camera: PinholeCamera,
    weights: FloatArray,
    *,
    corner_error: float,
    depth: MarkerPoints | None,
) -> NormalEquations:
    """Return what corners and depth say of a step of `perturbed`, to second order.

    The corners together count as one view of mean corners with `corner_error`: what the frames
    of a static camera share does not average out.
    """
    jacobian, miss = _corner_rows(pose, sightings, camera)
    each = np.repeat(_corner_weights(sightings, weights, corner_error), miss.shape[1])
    channels = [_channel(miss.ravel(), jacobian.reshape(-1, 6), each)]
    if depth is not None:
        rows, heights = _depth_rows(pose, depth)
        channels.append(_channel(heights, rows, _depth_weights(heights)))
    return equations(channels, 6)


def _channel(miss: FloatArray, jacobian: FloatArray, weights: FloatArray) -> ResidualChannel:
    """Weigh what is modelled less measured, shape (M,), with its derivative, shape (M, 6)."""
    cost = 0.5 * float(weights @ miss**2)
    return ResidualChannel(-miss, jacobian, Weights.of_squares(weights), cost)


def _depth_cost(pose: FloatArray, depth: MarkerPoints | None) -> float:
    """Return half of the weighed squares of the heights."""
    if depth is None:
        return 0.0
    heights = depth.heights(pose)
    return 0.5 * float(_depth_weights(heights) @ heights**2)


def _corner_weights(sightings: Sightings, weights: FloatArray, corner_error: float) -> FloatArray:
    """Return the weight of each sighting's coordinates [1/px^2], shape (s,)."""
    fraction: FloatArray = weights / weights.sum() * sightings.part_count / corner_error**2
    return fraction


def _weights(errors: FloatArray, scale: float) -> FloatArray:
    weights: FloatArray = 1.0 / (1.0 + (errors / (_OUTLIER * scale)) ** 2) ** 2
    return weights


def _corner_rows(
    pose: FloatArray, sightings: Sightings, camera: PinholeCamera
) -> tuple[FloatArray, FloatArray]:
    """Return d(pixel)/d(step), shape (s, 2 k, 6), and the misses [px], shape (s, 2 k)."""
    turned = sightings.points @ pose[:3, :3].T
    x, y, z = np.moveaxis(turned + pose[:3, 3], -1, 0)
    by_point = np.zeros((*x.shape, 2, 3))
    by_point[..., 0, 0] = camera.fx / z
    by_point[..., 0, 2] = -camera.fx * x / z**2
    by_point[..., 1, 1] = camera.fy / z
    by_point[..., 1, 2] = -camera.fy * y / z**2
    # A turn w moves a point by w x turned, so a row r changes by (turned x r) . w.
    by_turn = np.cross(turned[..., None, :], by_point)
    jacobian = np.concatenate([by_point, by_turn], axis=-1)
    miss = camera.project(turned + pose[:3, 3]) - sightings.pixels
    return jacobian.reshape(len(x), -1, 6), miss.reshape(len(x), -1)


def _depth_rows(pose: FloatArray, depth: MarkerPoints) -> tuple[FloatArray, FloatArray]:
    """Return d(height)/d(step), shape (n, 6), and the heights [m], shape (n,)."""
    normals = depth.normals @ pose[:3, :3].T
    turned = depth.origins @ pose[:3, :3].T
    arms = depth.points - pose[:3, 3] - turned
    # Turning moves both the normal and the marker's middle.
    by_turn = np.cross(normals, arms) - np.cross(turned, normals)
    return np.hstack([-normals, by_turn]), depth.heights(pose)


def _depth_weights(heights: FloatArray) -> FloatArray:
    """Weigh depth pixels so that together they count as a few independent ones."""
    spread = np.abs(heights - np.median(heights))
    scale = median_spread(spread) + 1e-4
    inlying = 1.0 / (1.0 + (spread / (_OUTLIER * scale)) ** 2)
    weights: FloatArray = inlying / inlying.sum() * _DEPTH_COUNT / _DEPTH_ERROR**2
    return weights
