# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body of which one long edge was planed off, so that its upper side falls to that."""

import numpy as np
from numpy.typing import NDArray

_RUN = 0.15  # Share of the free length over which the plane comes down beyond the clamp.


def bevelling(
    share: NDArray[np.float64], across: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how much lower places lie, 0 to 1: all of it at the upper edge of positive y.

    It falls evenly to the middle of the width, and to that of the height.

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides; beyond, of a crossbar, it is as there, that shape.
        high: -1 at the lower side and 1 at the upper one, that shape.
    """
    down = np.clip(share / _RUN, 0.0, 1.0)
    return np.asarray(down * np.clip(across, 0.0, 1.0) * np.clip(high, 0.0, 1.0))
