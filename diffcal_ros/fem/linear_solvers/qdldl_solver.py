# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""QDLDL: a small simplicial LDL^T, the fastest permissive one for small bodies."""

from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.interface import NotPositiveDefiniteError
import numpy as np
from numpy.typing import NDArray
import qdldl
from scipy.sparse import csc_matrix

FloatArray = NDArray[np.float64]


class QdldlSolver:
    """LDL^T with the ordering kept between matrices."""

    name = 'qdldl'
    is_exact = True
    few_sides = 3
    patience = 20

    def __init__(self, pattern: SparsePattern) -> None:
        shape = (pattern.size, pattern.size)
        lower = csc_matrix(
            (np.arange(1, pattern.entry_count + 1), pattern.row_indices, pattern.column_starts),
            shape=shape,
        )
        upper = lower.T.tocsc()
        upper.sort_indices()
        self._reorder = upper.data - 1
        self._matrix = csc_matrix((np.zeros(upper.nnz), upper.indices, upper.indptr), shape=shape)
        self._solver: qdldl.Solver | None = None

    def factor(self, values: FloatArray) -> None:
        """Factor; see `SparseSolver`."""
        self._matrix.data[:] = values[self._reorder]
        try:
            if self._solver is None:
                self._solver = qdldl.Solver(self._matrix, upper=True)
            else:
                self._solver.update(self._matrix, upper=True)
        except RuntimeError as error:
            self._solver = None
            raise NotPositiveDefiniteError(str(error)) from error
        _, pivots, _ = self._solver.factors()
        if (pivots <= 0.0).any():
            raise NotPositiveDefiniteError('negative pivot')

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve; see `SparseSolver`."""
        assert self._solver is not None
        if right_sides.ndim == 1:
            return np.asarray(self._solver.solve(right_sides))
        columns = [self._solver.solve(column) for column in np.ascontiguousarray(right_sides.T)]
        return np.stack(columns, axis=1) if columns else np.zeros_like(right_sides)
