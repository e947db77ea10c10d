# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""MKL Pardiso through pypardiso: the fastest here, one gigabyte of MKL."""

from weakref import finalize

from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.interface import NotPositiveDefiniteError
import numpy as np
from numpy.typing import NDArray
from pypardiso import PyPardisoSolver
from pypardiso.pardiso_wrapper import PyPardisoError
from scipy.sparse import csr_matrix

FloatArray = NDArray[np.float64]

_SYMMETRIC_POSITIVE_DEFINITE = 2
_ANALYSE, _FACTOR, _SOLVE, _RELEASE = 11, 22, 33, -1
# MKL's own values but for one, by their numbers in its manual: by itself it refines every solution
# twice (8), which takes three times as long and wins nothing on a definite matrix. That these
# values count (1) and that the ordering is nested dissection on all cores (2) must then be said.
_CHOICES = {1: 1, 2: 3, 8: 0}


class PardisoSolver:
    """Supernodal Cholesky; analysis once, on the first matrix."""

    name = 'pardiso'
    is_exact = True
    few_sides = 1
    patience = 20

    def __init__(self, pattern: SparsePattern) -> None:
        self._matrix = csr_matrix(
            (np.zeros(pattern.entry_count), pattern.row_indices, pattern.column_starts),
            shape=(pattern.size, pattern.size),
        )
        self._solver = PyPardisoSolver(mtype=_SYMMETRIC_POSITIVE_DEFINITE)
        for number, value in _CHOICES.items():
            self._solver.set_iparm(number, value)
        self._is_analysed = False

    def factor(self, values: FloatArray) -> None:
        """Factor; see `SparseSolver`."""
        self._matrix.data[:] = values
        if not self._is_analysed:
            self._call(_ANALYSE, np.zeros(self._matrix.shape[0]))
            # MKL keeps what it has until it is told otherwise. At its end a process need not.
            finalize(self, _release, self._solver, self._matrix).atexit = False
            self._is_analysed = True
        try:
            self._call(_FACTOR, np.zeros(self._matrix.shape[0]))
        except PyPardisoError as error:
            raise NotPositiveDefiniteError(str(error)) from error

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve; see `SparseSolver`."""
        return self._call(_SOLVE, right_sides)

    def _call(self, phase: int, right_sides: FloatArray) -> FloatArray:
        self._solver.set_phase(phase)
        columns = right_sides.reshape(len(right_sides), -1)
        solution = self._solver._call_pardiso(self._matrix, np.asfortranarray(columns))
        return np.ascontiguousarray(solution).reshape(right_sides.shape)


def _release(solver: PyPardisoSolver, matrix: csr_matrix) -> None:
    solver.set_phase(_RELEASE)
    solver._call_pardiso(matrix, np.zeros(matrix.shape[0]))
