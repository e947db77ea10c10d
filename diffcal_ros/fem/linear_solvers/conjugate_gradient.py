# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Conjugate gradients with an old factorisation as preconditioner."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Product = Callable[[FloatArray], FloatArray]

# Fewer steps tell no pace.
_PACED_FROM = 2


def conjugate_gradient(
    product: Product,
    precondition: Product,
    right_side: FloatArray,
    tolerance: float,
    max_steps: int,
    enough: float = 0.0,
    patience: float = np.inf,
) -> FloatArray | None:
    """Solve a symmetric system.

    Args:
        product: the matrix times a vector, shape (n,).
        precondition: an inverse much like the matrix's, times a vector.
        right_side: shape (n,).
        tolerance: share of the right side that may be left.
        max_steps: iterations at most.
        enough: share that may be left after so many.
        patience: give up once the pace so far would take more iterations to the tolerance.

    Returns:
        The solution, shape (n,); None when it is not found in so many steps, would not be
        for long, or the matrix is indefinite.
    """
    solution = precondition(right_side)
    residual = right_side - product(solution)
    goal = tolerance * float(np.linalg.norm(right_side))
    first = left = float(np.linalg.norm(residual))
    if left <= goal:
        return solution
    preconditioned = precondition(residual)
    search = preconditioned.copy()
    weight = float(residual @ preconditioned)
    for step in range(1, max_steps + 1):
        image = product(search)
        curvature = float(search @ image)
        if curvature <= 0.0:
            return None
        length = weight / curvature
        solution = solution + length * search
        residual = residual - length * image
        left = float(np.linalg.norm(residual))
        if left <= goal:
            return solution
        if step >= _PACED_FROM and _steps_left(first, left, step, goal) > patience:
            return None
        preconditioned = precondition(residual)
        before, weight = weight, float(residual @ preconditioned)
        search = preconditioned + weight / before * search
    return solution if left <= enough * goal / tolerance else None


def _steps_left(first: float, left: float, steps: int, goal: float) -> float:
    """Return how many more steps lead from what is left to the goal at the pace so far."""
    if left >= first:
        return np.inf
    return steps * float(np.log(left / goal) / np.log(first / left))
