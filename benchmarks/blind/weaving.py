# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that was woven through a grid: each wire left a short bend, one way and back in turn."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

WIRE = 0.08  # Share of the free length that a wire bends.


def woven(curvature: FloatArray, faults: Faults) -> list[tuple[float, float, FloatArray]]:
    """Return begin and end of the bends of a body and how they are bent, the outer one first.

    Each wire turns it by as much, the first and all odd ones one way and the even ones back;
    between them it stayed straight. The tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        faults: say at which shares of the free length the wires were.
    """
    places = np.sort(faults.curvature_wires)
    ways = (-1.0) ** np.arange(len(places))
    rate = 0.5 / (WIRE * float(ways @ (1.0 - places))) * curvature
    half = 0.5 * WIRE
    bends = [
        (float(place) - half, float(place) + half, way * rate)
        for place, way in zip(places, ways, strict=True)
    ]
    return bends[::-1]
