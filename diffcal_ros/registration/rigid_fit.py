# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit the pose of a rigid part to depth and outline, with what pixels are off by together."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.residuals.correlation import correlation_lengths
from diffcal_ros.calibration.residuals.robust_residual import Reach
from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.median_spread import median_spread
from diffcal_ros.registration.rigid_view import RigidImage, Sights
from diffcal_ros.registration.sensor_errors import IMAGE_SHIFT, outline_columns, SIZE, SmoothField
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Steps go from far to near: how far depth and outline are looked for [m], [px].
_FAR = (Reach(0.03, 0.03, 12), Reach(0.012, 0.02, 8))
_NEAR = Reach(0.005, 0.015, 5)
_STEPS, _SMALL, _ROUNDS = 10, 2e-6, 3
# Rounds of steps with scales anew, until the part moves by less [m].
_RESCALED, _SETTLED = 4, 2e-5
# A step shifts no more than this share of the reach, and turns no more than that [rad].
_LONGEST, _TURN = 0.5, 0.15
# Cauchy's cost has this width [standard deviations]: 95 % as good as squares on clean data.
_WIDTH = 2.385
# Fewer pixels than that say nothing; so near is the part's own depth [m].
_FEWEST, _AGREES = 100, 0.003
# No more pixels than that are alike beside the smooth error: what is longer is of that.
_MOST_ALIKE = 30.0
# What is known of a pose beforehand [m], [rad]: a direction that nothing determines has that
# variance.
_ANYWHERE, _ANYHOW = 0.3, 1.5
# No pixel, and no piece of an outline, is better than this [m], [px].
_FINEST, _FINEST_EDGE = 5e-5, 0.3


@dataclass(frozen=True)
class RigidFit:
    """A pose at the end of a fit.

    Attributes:
        depth_from_object: shape (4, 4).
        covariance: of a shift of the part's middle [m] and a turn about it [rad], in the camera's
            frame, shape (6, 6).
        noise: of one pixel of depth beside the smooth error [m].
        pixels: of depth that agree.
    """

    depth_from_object: FloatArray
    covariance: FloatArray
    noise: float
    pixels: float


def moved_pose(pose: FloatArray, step: FloatArray, pivot: FloatArray) -> FloatArray:
    """Return a pose shifted and turned about a point of its own frame.

    Args:
        pose: depth_from_object, shape (4, 4).
        step: shift [m] and turn [rad] in the camera's frame, shape (6,).
        pivot: in the object frame [m], shape (3,).
    """
    turned = rotation_matrix(step[3:]) @ pose[:3, :3]
    middle = pose[:3, :3] @ pivot + pose[:3, 3]
    return transform(turned, middle + step[:3] - turned @ pivot)


def approach(image: RigidImage, start: FloatArray) -> FloatArray | None:
    """Return a pose fitted from far; None where the camera then sees nothing of the part."""
    pose = start
    try:
        for reach in _FAR:
            pose, _ = _descend(image, pose, reach, None)
    except OutOfViewError:
        return None
    return pose


def settle(image: RigidImage, start: FloatArray) -> RigidFit | None:
    """Fit a pose from near, its covariance with it; None where nothing is seen from there."""
    try:
        pose, _ = _descend(image, start, _NEAR, None)
        sights = image.sights(pose, _NEAR, is_final=True)
        if len(sights.values[0]) < _FEWEST:
            return None
        field = SmoothField.over(sights.pixels[0].min(axis=0), sights.pixels[0].max(axis=0))
        pose, design = _descend(image, pose, _NEAR, field)
    except OutOfViewError:
        return None
    covariance = np.linalg.inv(design.curvature)[:6, :6]
    return RigidFit(
        pose,
        0.5 * (covariance + covariance.T),
        design.scales.noise[0],
        design.agreeing,
    )


@dataclass(frozen=True)
class Scales:
    """Standard deviation of what each value is off by alone, and how many say the same.

    Attributes:
        noise: of depth and of outline [m].
        alike: pixels that are worth one.
    """

    noise: tuple[float, float]
    alike: tuple[float, float]


@dataclass(frozen=True)
class Design:
    """Normal equations of a pose and of what pixels are off by together, about a pose.

    Attributes:
        cost: robust, half chi-square, at the pose with the latter at its best.
        unknowns: step of the pose, and the latter, at the minimum, shape (6 + k,).
        curvature: priors included, shape (6 + k, 6 + k).
        precision: of the priors, shape (6 + k,).
        pull: minus the gradient where all are zero, shape (6 + k,).
        smooth: which unknowns are the smooth error's.
        scales: that were used.
        agreeing: pixels of depth that agree.
    """

    cost: float
    unknowns: FloatArray
    curvature: FloatArray
    precision: FloatArray
    pull: FloatArray
    smooth: slice
    scales: Scales
    agreeing: float


def _descend(
    image: RigidImage, start: FloatArray, reach: Reach, shared: SmoothField | None
) -> tuple[FloatArray, Design]:
    """Take Gauss-Newton steps until they are small, and again with the scales found there."""
    pose, design = _steps(image, start, reach, shared)
    for _ in range(_RESCALED):
        before = pose
        pose, design = _steps(image, pose, reach, shared)
        if _distance(image, before, pose) < _SETTLED:
            break
    return pose, design


def _steps(
    image: RigidImage, start: FloatArray, reach: Reach, shared: SmoothField | None
) -> tuple[FloatArray, Design]:
    """Take steps with the scales of the first one; return where they end.

    As edges come into reach and go the cost jumps; where the steps are small the pose is taken
    whatever it is, and else where it was lowest.
    """
    pose, best, scales = start, None, None
    for _ in range(_STEPS):
        sights = image.sights(pose, reach, is_final=shared is not None)
        design = expand(sights, shared, reach, scales)
        scales = design.scales
        if best is None or design.cost < best[1].cost:
            best = pose, design
        step = design.unknowns[:6]
        shift = float(np.linalg.norm(step[:3])) / (_LONGEST * reach.depth)
        step = step / max(1.0, shift, float(np.linalg.norm(step[3:])) / _TURN)
        if np.linalg.norm(step[:3]) + image.radius * np.linalg.norm(step[3:]) < _SMALL:
            return pose, design
        pose = moved_pose(pose, step, image.pivot)
    assert best is not None
    return best


def _distance(image: RigidImage, first: FloatArray, second: FloatArray) -> float:
    """Return how far the part moves between two poses, root mean square [m]."""
    apart = apply(first, image.positions) - apply(second, image.positions)
    return float(np.sqrt((apart**2).sum(axis=1).mean()))


def expand(
    sights: Sights, shared: SmoothField | None, reach: Reach, scales: Scales | None = None
) -> Design:
    """Expand the cost about a pose.

    Args:
        sights: there.
        shared: the smooth error of depth, other common ones beside it; None: none at all.
        reach: how far was looked.
        scales: to use; None: those that the values show.
    """
    columns = _columns(sights, shared)
    counts = [own.shape[1] for own in columns]
    size = 6 + sum(counts)
    smooth = slice(6, 6 + (0 if shared is None else shared.count))
    precision = np.ones(size)
    precision[:3], precision[3:6] = _ANYWHERE**-2, _ANYHOW**-2
    if shared is not None:
        precision[smooth] = SIZE**-2
    designs = []
    for kind, first in ((0, 6), (1, 6 + counts[0])):
        design = np.zeros((len(sights.values[kind]), size))
        design[:, :6] = sights.jacobian[kind]
        design[:, first : first + counts[kind]] = columns[kind]
        designs.append(design)
    is_free = np.arange(size) >= 6
    unknowns, used = np.zeros(size), scales or _scales(sights, sights.values, 1.0)
    for number in range(1 if shared is None else _ROUNDS):
        # What the pose is off by stays in what is weighed.
        left = [
            values - design @ (unknowns * is_free)
            for values, design in zip(sights.values, designs, strict=True)
        ]
        if scales is None and number:
            used = _scales(sights, left, _patch(sights.pixels[0], left[0]))
        weights = [_weights(sights, kind, left[kind], used) for kind in (0, 1)]
        curvature = np.diag(precision) + sum(
            (design * own[:, None]).T @ design
            for design, own in zip(designs, weights, strict=True)
        )
        pull = sum(
            design.T @ (own * values)
            for design, own, values in zip(designs, weights, sights.values, strict=True)
        )
        unknowns = np.linalg.solve(curvature, pull)
    cost = sum(_cost(sights, kind, left[kind], used, reach) for kind in (0, 1))
    return Design(
        cost=cost + 0.5 * float(precision[6:] @ unknowns[6:] ** 2),
        unknowns=unknowns,
        curvature=curvature,
        precision=precision,
        pull=pull,
        smooth=smooth,
        scales=used,
        agreeing=float(sights.weights[0] @ (np.abs(left[0]) < _AGREES)),
    )


def _columns(sights: Sights, shared: SmoothField | None) -> tuple[FloatArray, FloatArray]:
    """Return what unknowns of the sensor do to depth and to outline, (M, k) and (L, k)."""
    if shared is None:
        return np.zeros((len(sights.values[0]), 0)), np.zeros((len(sights.values[1]), 0))
    aside = IMAGE_SHIFT * sights.pixel_size * sights.jacobian[0][:, :2]
    return (
        np.hstack([shared.columns(sights.pixels[0]), aside]),
        outline_columns(sights.pixels[1], sights.normals, sights.scale),
    )


def _scales(sights: Sights, left: Sequence[FloatArray], alike: float) -> Scales:
    """Return what each value is off by alone, where so many pixels say the same."""
    depth, edge = (median_spread(own) if len(own) else 0.0 for own in left)
    return Scales(
        (max(depth, _FINEST), max(edge, _FINEST_EDGE * sights.pixel_size)),
        (alike, 1.0),
    )


def _patch(pixels: FloatArray, left: FloatArray) -> float:
    """Return how many neighbouring pixels are worth one."""
    if len(left) < _FEWEST:
        return 1.0
    columns, rows = (pixels - pixels.min(axis=0)).astype(np.int64).T
    image = np.zeros((int(rows.max()) + 1, int(columns.max()) + 1))
    mask = np.zeros(image.shape, dtype=bool)
    limit = 4.0 * max(median_spread(left), _FINEST)
    image[rows, columns] = np.clip(left, -limit, limit)
    mask[rows, columns] = True
    side, _ = correlation_lengths(image, mask)
    return float(np.clip(side**2, 1.0, _MOST_ALIKE))


def _weights(sights: Sights, kind: int, left: FloatArray, scales: Scales) -> FloatArray:
    """Return the weights of Cauchy's cost, shape (M,)."""
    noise = scales.noise[kind]
    robust = 1.0 + (left / (_WIDTH * noise)) ** 2
    weights: FloatArray = sights.weights[kind] / (noise**2 * scales.alike[kind] * robust)
    return weights


def _cost(sights: Sights, kind: int, left: FloatArray, scales: Scales, reach: Reach) -> float:
    """Return Cauchy's cost; what was not found is as far off as was looked."""
    width = _WIDTH * scales.noise[kind]
    limit = reach.depth if kind == 0 else reach.edge_pixels * sights.pixel_size
    total = sights.weights[kind] @ np.log1p((left / width) ** 2)
    total += sights.missing[kind] * np.log1p((limit / width) ** 2)
    return 0.5 * _WIDTH**2 * float(total) / scales.alike[kind]
