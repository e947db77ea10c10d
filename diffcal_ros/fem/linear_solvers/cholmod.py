# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""CHOLMOD through cvxopt: supernodal and fast, GPL, so only where the user installed it."""

from cvxopt import cholmod, matrix, spmatrix
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.interface import NotPositiveDefiniteError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class CholmodSolver:
    """Supernodal Cholesky; the ordering is kept between matrices."""

    name = 'cholmod'
    is_exact = True
    few_sides = 1
    patience = 20

    def __init__(self, pattern: SparsePattern) -> None:
        columns = np.repeat(np.arange(pattern.size), np.diff(pattern.column_starts))
        diagonal = (pattern.row_indices == columns).astype(np.float64)
        self._matrix = spmatrix(
            matrix(diagonal),
            matrix(pattern.row_indices.astype(np.int64)),
            matrix(columns.astype(np.int64)),
            (pattern.size, pattern.size),
        )
        self._factor = cholmod.symbolic(self._matrix)

    def factor(self, values: FloatArray) -> None:
        """Factor; see `SparseSolver`."""
        self._matrix.V = matrix(values)
        try:
            cholmod.numeric(self._matrix, self._factor)
        except ArithmeticError as error:
            raise NotPositiveDefiniteError(f'pivot {error}') from error

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve; see `SparseSolver`."""
        solution = matrix(np.asfortranarray(right_sides))
        cholmod.solve(self._factor, solution)
        return np.array(solution).reshape(right_sides.shape)
