# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A box around what a clamp holds."""

from dataclasses import dataclass

from diffcal_ros.rigid_transform import transform
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# It stands out of the body by this share of the box's longest side.
_RIM = 0.04


@dataclass(frozen=True)
class HeldBox:
    """A box.

    Attributes:
        object_from_box: its middle and axes in the body's own frame, shape (4, 4).
        sides: [m], shape (3,).
    """

    object_from_box: FloatArray
    sides: FloatArray


def box_around(points: FloatArray, direction: FloatArray, low: float | None = None) -> HeldBox:
    """Return a box around points, its first axis along a direction.

    Args:
        points: object frame [m], shape (h, 3).
        direction: unit, shape (3,).
        low: where it begins along `direction` [m]; None: at the first of the points.
    """
    # The frame's axis that is least along the direction gives the second one.
    second = np.eye(3)[int(np.argmin(np.abs(direction)))]
    second = second - (second @ direction) * direction
    second /= np.linalg.norm(second)
    axes = np.stack([direction, second, np.cross(direction, second)])
    along = points @ axes.T
    lowest, highest = along.min(axis=0), along.max(axis=0)
    if low is not None:
        lowest[0], highest[0] = low, max(highest[0], low)
    rim = _RIM * float((highest - lowest).max())
    # The plane at which the clamp begins stays where it is.
    lowest[1:], highest = lowest[1:] - rim, highest + rim
    middle = axes.T @ (0.5 * (lowest + highest))
    return HeldBox(transform(axes.T, middle), highest - lowest)
