# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is another one at places along the body, and between them in proportion."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def at_share(share: float) -> str:
    """Say how far along the body a place is."""
    return f'at {share:.0%} of its length'


def hat(shares: FloatArray, places: FloatArray, number: int) -> FloatArray:
    """Return what is one at one place, none at all others, and linear between, shape (n,).

    Args:
        shares: of the body's length, shape (n,).
        places: likewise, ascending, shape (p,).
        number: of the place, from 1 on.
    """
    return np.interp(shares, places, np.eye(len(places))[number - 1])
