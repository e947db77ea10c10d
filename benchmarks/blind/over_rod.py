# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that was pressed over a rod, with both ends held down level."""

from itertools import pairwise

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

_PARTS = 8  # Arcs on either side of the rod.


def rod_moment(share: float, at: float) -> float:
    """Return the moment of a beam with both ends held, over that at the rod which loads it.

    It goes evenly from each end to the rod, and both ends turn as little as they shift.

    Args:
        share: of the free length.
        at: that of the rod.
    """
    if share < at:
        return share / at - 0.5 * (1.0 - share / at) / at
    left = (1.0 - share) / (1.0 - at)
    return left - 0.5 * (1.0 - left) / (1.0 - at)


def over_rod(curvature: FloatArray, faults: Faults) -> list[tuple[float, float, FloatArray]]:
    """Return begin and end of the parts of a body and how they are bent, the outer one first.

    Args:
        curvature: at the rod [1/m], shape (3,).
        faults: say at which share of the free length that was.
    """
    at = faults.curvature_at
    ends = [*np.linspace(0.0, at, _PARTS + 1), *np.linspace(at, 1.0, _PARTS + 1)[1:]]
    # The moment amid a part is its mean, so that all parts turn the tip by nothing.
    found = [
        (float(one), float(two), rod_moment(0.5 * float(one + two), at) * curvature)
        for one, two in pairwise(ends)
    ]
    return found[::-1]
