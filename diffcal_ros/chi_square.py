# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Chances of sums of squares, without SciPy's distributions, which take a second to load."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import chdtrc, chdtri


def chance_beyond(chi_square: ArrayLike, freedom: float) -> NDArray[np.float64]:
    """Return the chance of a sum of squares of unit normals that is larger.

    Args:
        chi_square: rounding may leave it below zero; of any shape.
        freedom: how many squares; of what is believed in part a fraction.
    """
    return np.asarray(chdtrc(freedom, np.maximum(chi_square, 0.0)))


def exceeded_with(chance: float, freedom: float) -> float:
    """Return the sum of squares that is exceeded with such a chance."""
    return float(chdtri(freedom, chance))
