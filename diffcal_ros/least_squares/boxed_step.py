# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A Gauss-Newton step in a box: a coordinate that would go too far is stopped, the others go on.

Far from the minimum a motion says little of damping and much of stiffness and of the release:
shortening the whole step for the sake of damping would keep those from getting there.
"""

from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
from diffcal_ros.least_squares.normal_equations import NormalEquations
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def boxed_step(
    linear: NormalEquations,
    coordinates: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    step: FloatArray,
    longest_step: FloatArray,
    damping: float = 0.0,
) -> FloatArray:
    """Stop coordinates at their longest step, the worst first, and solve for the others anew.

    Args:
        linear: normal equations.
        coordinates: shape (k,).
        bounds: lower and upper, shape (k,) each.
        step: what the equations say without limits, shape (k,).
        longest_step: of each coordinate, shape (k,).
        damping: of Levenberg and Marquardt.

    Returns:
        A step within the limits, shape (k,); the same one where it was within them.
    """
    held, fixed = np.zeros(len(step), dtype=bool), np.zeros(len(step))
    for _ in range(len(step)):
        excess = np.where(held, 0.0, np.abs(step) / longest_step)
        worst = int(excess.argmax())
        if excess[worst] <= 1.0:
            break
        held[worst] = True
        fixed[worst] = np.sign(step[worst]) * longest_step[worst]
        free = ~held
        # Of the free coordinates, while the others are where they are held.
        negative_gradient = (linear.negative_gradient - linear.curvature @ fixed)[free]
        reduced = NormalEquations(
            linear.cost, negative_gradient, linear.curvature[np.ix_(free, free)]
        )
        step = fixed.copy()
        step[free] = gauss_newton_step(
            reduced, coordinates[free], bounds[0][free], bounds[1][free], damping
        )
    return step
