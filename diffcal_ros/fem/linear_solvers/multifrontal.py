# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Multifrontal Cholesky (Duff and Reid 1983) on the BLAS that SciPy brings along.

Unknowns are eliminated in groups, each in a dense matrix, so that nearly all the work is products
of dense matrices. Factors of large bodies are kept in single precision, which takes half the
memory and two thirds of the time; conjugate gradients with them gain two digits an iteration.
"""

from typing import Any

from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.frontal_kernels import add_update_double, add_update_single
from diffcal_ros.fem.linear_solvers.frontal_plan import Front, make_plan
from diffcal_ros.fem.linear_solvers.interface import NotPositiveDefiniteError
from diffcal_ros.warp_runtime.device_array import int_array
from diffcal_ros.warp_runtime.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import get_blas_funcs
from scipy.linalg.lapack import get_lapack_funcs
import warp as wp

FloatArray = NDArray[np.float64]

# Factors with more numbers are kept in single precision: 25,000 quadratic tetrahedra.
_DOUBLE_LIMIT = 60_000_000
# Where rounding to single precision leaves a negative pivot, the diagonal grows by such a share.
_SINGLE_SHIFT = 1e-5


class MultifrontalSolver:
    """Cholesky factorisation along a nested dissection of the nodes."""

    name = 'multifrontal'

    def __init__(
        self, pattern: SparsePattern, *, is_exact: bool | None = None, per_node: int = 3
    ) -> None:
        """Lay out the factors.

        Args:
            pattern: where the entries are.
            is_exact: keep factors in double precision; default: unless they are large.
            per_node: unknowns of each node; with one, the matrix has one entry for each of the
                pattern's blocks.
        """
        self._plan = make_plan(pattern, per_node)
        self.is_exact = self._plan.store_size < _DOUBLE_LIMIT if is_exact is None else is_exact
        # A factorisation costs the more beside a solution the larger the body is.
        self.few_sides, self.patience = (0, 10) if self.is_exact else (1, 30)
        diagonal = pattern.diagonal_slots if per_node == 3 else pattern.block_starts[:-1]
        self._diagonal = self._plan.indices[diagonal]
        self._launcher = Launcher('cpu')
        self._into = int_array(self._plan.into, 'cpu')
        self._table = int_array(self._plan.table, 'cpu')
        self._number = np.float64 if self.is_exact else np.float32
        self._on_device = wp.float64 if self.is_exact else wp.float32
        self._add_update = add_update_double if self.is_exact else add_update_single
        self._potrf = get_lapack_funcs('potrf', dtype=self._number)
        self._syrk, self._trsm, self._trsv = get_blas_funcs(
            ('syrk', 'trsm', 'trsv'), dtype=self._number
        )
        self._store: Any = None
        self._stacks: list[Any] = []
        self._blocks: list[tuple[NDArray[Any], NDArray[Any]]] = []

    def factor(self, values: FloatArray) -> None:
        """Factor; see `SparseSolver`."""
        try:
            self._factor(values, 0.0)
        except NotPositiveDefiniteError:
            if self.is_exact:
                raise
            self._factor(values, _SINGLE_SHIFT)

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve; see `SparseSolver`."""
        if right_sides.ndim == 1:
            return self._solve_one(right_sides.astype(self._number)).astype(np.float64)
        return self._solve_some(right_sides.astype(self._number)).astype(np.float64)

    def _factor(self, values: FloatArray, shift: float) -> None:
        if self._store is None:
            self._make_store()
        store = self._store.numpy()
        store.fill(0.0)
        store[self._plan.indices] = values
        store[self._diagonal] *= 1.0 + shift
        for front, (pivots, panel) in zip(self._plan.fronts, self._blocks, strict=True):
            update = self._gather(front)
            _, failed = self._potrf(pivots, lower=1, clean=0, overwrite_a=1)
            if failed:
                raise NotPositiveDefiniteError(f'pivot {failed} of {len(front.own)} in a front')
            if len(front.border):
                self._trsm(1.0, pivots, panel, side=1, lower=1, trans_a=1, overwrite_b=1)
                self._syrk(-1.0, panel, beta=1.0, c=update, lower=1, overwrite_c=1)

    def _make_store(self) -> None:
        self._store = wp.empty(self._plan.store_size, dtype=self._on_device, device='cpu')
        # Kept, for the system takes long to give memory anew.
        self._stacks = [
            wp.empty(size, dtype=self._on_device, device='cpu') for size in self._plan.stack_sizes
        ]
        store = self._store.numpy()
        for front in self._plan.fronts:
            n, m = len(front.own), len(front.border)
            pivots = store[front.pivots : front.pivots + n * n].reshape((n, n), order='F')
            panel = store[front.panel : front.panel + n * m].reshape((m, n), order='F')
            self._blocks.append((pivots, panel))

    def _gather(self, front: Front) -> NDArray[Any]:
        """Add what the children left to a front; return its own matrix on the stack, (m, m)."""
        m = len(front.border)
        own = slice(front.update, front.update + m * m)
        update: NDArray[Any] = self._stacks[front.stack].numpy()[own].reshape((m, m), order='F')
        update.fill(0.0)
        for child in front.children:
            self._launcher.launch(
                self._add_update,
                len(self._plan.fronts[child].border),
                [child, self._table, self._into, self._stacks[1 - front.stack]],
                [self._store, self._stacks[front.stack]],
            )
        return update

    def _solve_one(self, x: NDArray[Any]) -> NDArray[Any]:
        """Solve in place, shape (n,)."""
        for front, (pivots, panel) in zip(self._plan.fronts, self._blocks, strict=True):
            own = self._trsv(pivots, x[front.own], lower=1, overwrite_x=1)
            x[front.own] = own
            x[front.border] -= panel @ own
        for front, (pivots, panel) in zip(
            reversed(self._plan.fronts), reversed(self._blocks), strict=True
        ):
            own = x[front.own] - x[front.border] @ panel
            x[front.own] = self._trsv(pivots, own, lower=1, trans=1, overwrite_x=1)
        return x

    def _solve_some(self, x: NDArray[Any]) -> NDArray[Any]:
        """Solve in place, shape (n, k)."""
        for front, (pivots, panel) in zip(self._plan.fronts, self._blocks, strict=True):
            own = self._trsm(1.0, pivots, x[front.own], lower=1)
            x[front.own] = own
            x[front.border] -= panel @ own
        for front, (pivots, panel) in zip(
            reversed(self._plan.fronts), reversed(self._blocks), strict=True
        ):
            own = x[front.own] - panel.T @ x[front.border]
            x[front.own] = self._trsm(1.0, pivots, own, lower=1, trans_a=1)
        return x
