# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that was kept wrapped around a square post: a short bend at each of its corners."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

CORNER = 0.07  # Share of the free length that a corner bends.


def wrapped(curvature: FloatArray, faults: Faults) -> list[tuple[float, float, FloatArray]]:
    """Return begin and end of the bends of a body and how they are bent, the outer one first.

    Each corner turns it by as much, the same way; along the post's sides it stayed straight. The
    tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        faults: say at which shares of the free length the corners were.
    """
    places = np.sort(faults.curvature_corners)
    rate = 0.5 / (CORNER * float((1.0 - places).sum())) * curvature
    half = 0.5 * CORNER
    return [(float(place) - half, float(place) + half, rate) for place in places[::-1]]
