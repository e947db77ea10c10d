# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cost to second order around some coordinates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Linearisation:
    """The cost to second order around some coordinates.

    Attributes:
        cost: half chi-square, priors included.
        descent: minus the gradient, shape (k,).
        curvature: Gauss-Newton matrix, priors included, shape (k, k).
        information: of the data alone, true curvature of the robust cost, shape (k, k).
        scatter: covariance of the data's part of the gradient, shape (k, k).
    """

    cost: float
    descent: FloatArray
    curvature: FloatArray
    information: FloatArray
    scatter: FloatArray
