# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A mould whose halves gape on one side, so that rubber stands out there as a ridge."""

import numpy as np
from numpy.typing import NDArray

_BRIM = 0.15  # Share of the free length over which a ridge comes up beyond the clamp.


def keeling(
    share: NDArray[np.float64], across: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how much farther out places lie, 0 to 1: a ridge amid the side of positive y.

    It falls evenly to the upper and the lower edge, and to the body's middle.

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides; beyond, of a crossbar, it is as there; that shape.
        high: -1 at the lower side and 1 at the upper one, that shape.
    """
    out = np.clip(across, 0.0, 1.0) * (1.0 - np.minimum(np.abs(high), 1.0))
    return np.asarray(np.clip(share / _BRIM, 0.0, 1.0) * out)
