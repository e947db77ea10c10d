# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a step's factorisation leaves out: rounds where that is little, GMRES where it is not.

Y. Saad, Iterative Methods for Sparse Linear Systems (2003): 4.1 (rounds), 6.5 (GMRES). A damping
that outweighs inertia and stiffness has rounds grow; GMRES knows no such limit, at the price of
one solve after the other.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import gmres, LinearOperator

FloatArray = NDArray[np.float64]
Rest = Callable[[FloatArray], FloatArray]

# What the matrix leaves out of damping and drag is a thousandth of it: a round or two settle that.
_TOLERANCE = 1e-8
_MAX_ROUNDS = 30
# Of those that did not settle by rounds none was seen to take more than a few dozen directions.
_DIRECTIONS, _RESTARTS = 100, 4


def solve_with_rest(rest: Rest, first: FloatArray) -> FloatArray | None:
    """Solve x + rest(x) = first.

    Args:
        rest: the inverse of the factored part times what is left out, of sides (k, N, 3).
        first: the solution without that, shape (k, N, 3).

    Returns:
        The solution; None when it is not found.
    """
    found = _by_rounds(rest, first)
    if found is not None:
        return found
    columns = []
    for side in first:
        found = _by_directions(rest, side)
        if found is None:
            return None
        columns.append(found)
    return np.stack(columns)


def _by_rounds(rest: Rest, first: FloatArray) -> FloatArray | None:
    solution, last, size = first, first, _sizes(first)
    for _ in range(_MAX_ROUNDS):
        before = _sizes(last)
        last = -rest(last)
        solution = solution + last
        now = _sizes(last)
        # The next round is smaller than this one by as much as this one than the last.
        if (now * now <= _TOLERANCE * size * before).all():
            return solution
        if (now > size).any():
            return None
    return None


def _by_directions(rest: Rest, first: FloatArray) -> FloatArray | None:
    def product(side: FloatArray) -> FloatArray:
        return side + rest(side.reshape(1, *first.shape)).ravel()

    operator = LinearOperator((first.size, first.size), matvec=product, dtype=np.float64)
    found, left = gmres(
        operator, first.ravel(), rtol=_TOLERANCE, restart=_DIRECTIONS, maxiter=_RESTARTS
    )
    return found.reshape(first.shape) if left == 0 else None


def _sizes(sides: FloatArray) -> FloatArray:
    """Return the largest number of each side, shape (k,)."""
    return np.asarray(np.abs(sides).max(axis=(1, 2)))
