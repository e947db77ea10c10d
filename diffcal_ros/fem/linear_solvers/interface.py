# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What every sparse solver offers."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class NotPositiveDefiniteError(ArithmeticError):
    """The matrix has a negative or zero pivot: the state is no stable equilibrium."""


class SparseSolver(Protocol):
    """Analyses a pattern once, then factors many matrices.

    Attributes:
        name: by which it is chosen.
        few_sides: right-hand sides for which iterations with an old factorisation take less time
            than a new one.
        patience: iterations with an old factorisation that take about as long as a new one.
        is_exact: its solutions are good to double precision; else to some two digits, and serve
            to precondition iterations.
    """

    name: str
    few_sides: int
    patience: int
    is_exact: bool

    def factor(self, values: FloatArray) -> None:
        """Factor the matrix with these entries, shape (nnz,).

        Raises:
            NotPositiveDefiniteError: when a pivot is not positive.
        """

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve with the last factor for shape (n,) or (n, k)."""
