# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Conjugate gradients with an old factorisation as preconditioner."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Product = Callable[[FloatArray], FloatArray]


def conjugate_gradient(
    product: Product,
    precondition: Product,
    right_side: FloatArray,
    tolerance: float,
    max_steps: int,
    enough: float = 0.0,
) -> FloatArray | None:
    """Solve a symmetric system.

    Args:
        product: the matrix times a vector, shape (n,).
        precondition: an inverse much like the matrix's, times a vector.
        right_side: shape (n,).
        tolerance: share of the right side that may be left.
        max_steps: iterations at most.
        enough: share that may be left after so many.

    Returns:
        The solution, shape (n,); None when it is not found in so many steps, or the matrix is
        indefinite.
    """
    solution = precondition(right_side)
    residual = right_side - product(solution)
    goal = tolerance * float(np.linalg.norm(right_side))
    if np.linalg.norm(residual) <= goal:
        return solution
    preconditioned = precondition(residual)
    search = preconditioned.copy()
    weight = float(residual @ preconditioned)
    for _ in range(max_steps):
        image = product(search)
        curvature = float(search @ image)
        if curvature <= 0.0:
            return None
        length = weight / curvature
        solution = solution + length * search
        residual = residual - length * image
        if np.linalg.norm(residual) <= goal:
            return solution
        preconditioned = precondition(residual)
        before, weight = weight, float(residual @ preconditioned)
        search = preconditioned + weight / before * search
    return solution if np.linalg.norm(residual) <= enough * goal / tolerance else None
