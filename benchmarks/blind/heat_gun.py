# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that a heat gun warmed at one place, from where the heat spreads and fades."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray


def spread_heat(
    share: FloatArray, at: float, width: float, wider: float, number: int
) -> FloatArray:
    """Return how warm a body is in a pose, over how warm it was there in the first, any shape.

    By the kernel of the equation of heat: the square of its width grows with the time, and what
    is below it stays; poses are alike in time.

    Args:
        share: of the free length, any shape.
        at: that before the gun.
        width: share over which it falls to a third in the first pose.
        wider: by which share of that pose's the square of the width grows from pose to pose.
        number: of the pose, from 0.
    """
    grown = 1.0 + wider * number
    away = (np.asarray(share) - at) / width
    return np.asarray(np.exp(-(away**2) / grown) / np.sqrt(grown))


def gun_heat(share: FloatArray, faults: Faults, number: int) -> FloatArray:
    """Return the same as faults say it, any shape."""
    at, width = faults.contrast_at, faults.contrast_width
    return spread_heat(share, at, width, faults.contrast_wider, number)
