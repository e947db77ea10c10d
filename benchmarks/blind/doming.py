# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A mould whose end was round like a thimble's: a body's end is a dome, not flat."""

import numpy as np
from numpy.typing import NDArray

_FROM = 0.7  # Share of the free length from which on a body is shorter.


def doming(share: NDArray[np.float64], across: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much of a dome's height places lie farther back, 0 to 1.

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides along y and z, shape (..., 2).
    """
    inner = np.prod(1.0 - np.minimum(across**2, 1.0), axis=-1)
    return np.asarray(np.clip((share - _FROM) / (1.0 - _FROM), 0.0, 1.0) * (1.0 - inner))
