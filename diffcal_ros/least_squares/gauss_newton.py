# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One Gauss-Newton step of a cost that is known to second order."""

from diffcal_ros.least_squares.normal_equations import NormalEquations
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def gauss_newton_step(
    linear: NormalEquations,
    coordinates: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    damping: float = 0.0,
) -> FloatArray:
    """Solve the damped normal equations for what is not stopped by a bound, shape (k,)."""
    stopped = (coordinates <= lower) & (linear.negative_gradient < 0.0)
    stopped |= (coordinates >= upper) & (linear.negative_gradient > 0.0)
    free = np.flatnonzero(~stopped)
    step = np.zeros_like(coordinates)
    if len(free) == 0:
        return step
    curvature = linear.curvature[np.ix_(free, free)]
    diagonal = np.diag(curvature)
    # A coordinate that nothing depends on stays where it is.
    damped = curvature + np.diag(damping * diagonal + np.where(diagonal > 0.0, 0.0, 1.0))
    scale = 1.0 / np.sqrt(np.diag(damped))
    scaled = damped * scale[:, None] * scale[None, :]
    solution, *_ = np.linalg.lstsq(scaled, scale * linear.negative_gradient[free], rcond=1e-12)
    step[free] = scale * solution
    return step
