# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A mould whose end wall stood aslant: one side of a body is shorter than the other."""

import numpy as np
from numpy.typing import NDArray

_FROM = 0.7  # Share of the free length from which on a body is shorter.


def mitring(share: NDArray[np.float64], across: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much of a cut places lie farther back, 0 to 1.

    Args:
        share: of the free length, any shape.
        across: -1 at the side that keeps its length and 1 at the one that is cut, that shape.
    """
    return np.asarray(np.clip((share - _FROM) / (1.0 - _FROM), 0.0, 1.0) * 0.5 * (1.0 + across))
