# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A mould of two halves that were not put in line, and meet in a bend like an S."""

import numpy as np
from numpy.typing import NDArray

_HALF = 0.1  # Share of the free length from the middle of the bend to either of its ends.


def jogging(share: NDArray[np.float64], far: float, at: float, way: float) -> NDArray[np.float64]:
    """Return how far places lie to the side, along y and z [m], shape (..., 2).

    Args:
        share: of the free length, any shape.
        far: beyond the bend [m].
        at: share amid the bend.
        way: from y towards z [deg].
    """
    through = np.clip(0.5 * (share - at) / _HALF + 0.5, 0.0, 1.0)
    # It is level where it begins and ends.
    over = far * through**2 * (3.0 - 2.0 * through)
    angle = np.deg2rad(way)
    return np.asarray(over[..., None] * np.array([np.cos(angle), np.sin(angle)]))
