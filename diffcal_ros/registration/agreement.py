# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well a depth image agrees with a rigid part, or with the body that it holds, at a pose."""

from diffcal_ros.calibration.residuals.robust_residual import Reach
from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.registration.rigid_view import RigidImage
import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

# How near depth and outline agree [m], [px]: one half is left of a pixel's say there.
_NEAR, _NEAR_EDGE = 0.001, 1.5
# Something in front, no measurement, and an outline that is not found speak less clearly.
_HIDDEN, _INVALID, _UNFOUND = 0.4, 0.25, 0.5
# So much is lost where no outline is found: the part would go on as something larger.
_OUTLINE_SHARE = 0.6
_REACH = Reach(0.05, 0.015, 5)
# The body near the part may hang so far from where it is at rest [m].
_NEAR_BODY = 0.004
_FEWEST = 25


def merit(image: RigidImage, pose: FloatArray, noise: float) -> float:
    """Return how well the image agrees, 1 at best; 0 where the part is out of view.

    Args:
        image: the part before a camera.
        pose: depth_from_object, shape (4, 4).
        noise: of a pixel [m].
    """
    try:
        view = image.view(pose)
    except OutOfViewError:
        return 0.0
    compared = image.compare(view, _REACH)
    near = max(_NEAR, 3.0 * noise)
    inside = _agreement(compared.difference[compared.counted], near)
    edge = compared.edge
    if not len(edge.values):
        return (1.0 - _OUTLINE_SHARE) * inside
    pixels = edge.values / compared.edge_scale
    found = edge.weights @ (1.0 / (1.0 + (pixels / _NEAR_EDGE) ** 2))
    outline = float(found / (edge.weights.sum() + _UNFOUND * edge.missing))
    return inside * (1.0 - _OUTLINE_SHARE + _OUTLINE_SHARE * outline)


def body_merit(
    image: RigidImage,
    pose: FloatArray,
    shown: BoolArray,
    positions: FloatArray | None = None,
) -> float:
    """Return how well the body is met where the pose puts it, 1 at best, NaN out of sight.

    Args:
        image: the part and the body before a camera.
        pose: depth_from_object, shape (4, 4).
        shown: which of the body's triangles are looked at, shape (F,).
        positions: of the body's vertices, object frame [m], shape (V, 3); None: at rest.
    """
    body = image.body_trace(pose, positions)
    if body is None:
        return float('nan')
    try:
        far = np.nan_to_num(image.view(pose).trace.full_depth(), nan=np.inf)
    except OutOfViewError:
        return float('nan')
    depth = body.full_depth()
    is_shown = np.zeros(depth.shape, dtype=bool)
    is_shown[body.rows, body.columns] = (body.faces >= 0) & shown[np.maximum(body.faces, 0)]
    seen = is_shown & (depth < far)
    if np.count_nonzero(seen) < _FEWEST:
        return float('nan')
    # Before a background that gives no depth the body is missed where nothing is measured.
    return _agreement((image.depth - depth)[seen], _NEAR_BODY, invalid=1.0)


def _agreement(difference: FloatArray, near: float, invalid: float = _INVALID) -> float:
    """Return the share of pixels that agree; measured less expected depth [m], shape (M,)."""
    is_valid = np.isfinite(difference)
    valid = difference[is_valid]
    weights = np.where(valid < -3.0 * near, _HIDDEN, 1.0)
    total = weights.sum() + invalid * np.count_nonzero(~is_valid)
    if total == 0.0:
        return 0.0
    return float(weights @ (1.0 / (1.0 + (valid / near) ** 2)) / total)
