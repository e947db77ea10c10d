# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""SuperLU (SciPy): always there."""

from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.interface import NotPositiveDefiniteError
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

FloatArray = NDArray[np.float64]


class SuperLuSolver:
    """LU in symmetric mode: no pivoting, so that the pivots' signs tell definiteness."""

    name = 'superlu'
    is_exact = True
    few_sides = 3
    patience = 20

    def __init__(self, pattern: SparsePattern) -> None:
        lower = csc_matrix(
            (np.arange(1, pattern.entry_count + 1), pattern.row_indices, pattern.column_starts),
            shape=(pattern.size, pattern.size),
        )
        off_diagonal = lower.copy()
        off_diagonal.setdiag(0)
        off_diagonal.eliminate_zeros()
        full = (lower + off_diagonal.T).tocsc()
        full.sort_indices()
        self._expand = full.data - 1
        self._matrix = csc_matrix(
            (np.zeros(full.nnz), full.indices, full.indptr), shape=full.shape
        )

    def factor(self, values: FloatArray) -> None:
        """Factor; see `SparseSolver`."""
        self._matrix.data[:] = values[self._expand]
        try:
            self._factor = splu(
                self._matrix,
                permc_spec='MMD_AT_PLUS_A',
                diag_pivot_thresh=0.0,
                options={'SymmetricMode': True},
            )
        except RuntimeError as error:  # SciPy's word for an exactly zero pivot.
            raise NotPositiveDefiniteError(str(error)) from error
        if (self._factor.U.diagonal() <= 0.0).any():
            raise NotPositiveDefiniteError('negative pivot')

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve; see `SparseSolver`."""
        return np.asarray(self._factor.solve(right_sides))
