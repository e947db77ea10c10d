# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Multifrontal Cholesky (Duff and Reid 1983) on the BLAS that SciPy brings along.

Unknowns are eliminated in groups, each in a dense matrix, so that nearly all the work is products
of dense matrices. Factors of large bodies are kept in single precision, which takes half the
memory and two thirds of the time; conjugate gradients with them gain two digits an iteration.
"""

from typing import Any, NamedTuple

from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.frontal_kernels import columns_kernel
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
# Of so many columns the triangle's inverse takes less time than smaller products.
_DIVIDED_AT_ONCE = 48


class _Block(NamedTuple):
    """A front's factors, and what it leaves for its parent; all by columns."""

    pivots: NDArray[Any]  # (n, n), lower triangle
    panel: NDArray[Any]  # (m, n)
    left: NDArray[Any]  # (m, m), lower triangle


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
        self.few_sides, self.patience = (0, 10) if self.is_exact else (1, 15)
        diagonal = pattern.diagonal_slots if per_node == 3 else pattern.block_starts[:-1]
        self._diagonal = self._plan.indices[diagonal]
        # One for each stack, so that no launch has other arguments than the last.
        self._launchers = Launcher('cpu'), Launcher('cpu')
        self._which = int_array(np.zeros(3, dtype=np.int32), 'cpu')
        self._which_numbers = self._which.numpy()
        self._into = int_array(np.append(self._plan.into[::per_node] // per_node, 0), 'cpu')
        self._table = int_array(self._plan.table, 'cpu')
        self._width = wp.int32(per_node)
        self._number = np.float64 if self.is_exact else np.float32
        number = wp.float64 if self.is_exact else wp.float32
        # A node's numbers at once take a third of the time.
        self._entry = number if per_node == 1 else wp.types.vector(per_node, number)
        self._add_columns = columns_kernel(self._entry)
        self._potrf, self._trtri = get_lapack_funcs(('potrf', 'trtri'), dtype=self._number)
        self._gemm, self._syrk, self._trmm, self._trsm, self._trsv = get_blas_funcs(
            ('gemm', 'syrk', 'trmm', 'trsm', 'trsv'), dtype=self._number
        )
        self._store: Any = None
        self._stacks: list[Any] = []
        self._blocks: list[_Block] = []

    def factor(self, values: FloatArray) -> None:
        """Factor; see `SparseSolver`."""
        try:
            self._factor(values, 0.0)
        except NotPositiveDefiniteError:
            if self.is_exact:
                raise
            self._factor(values, _SINGLE_SHIFT)

    def finish(self) -> None:
        """Free what another factorisation would need: this matrix stays the last one."""
        self._stacks.clear()
        self._blocks = [block._replace(left=block.left[:0, :0].copy()) for block in self._blocks]

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve; see `SparseSolver`."""
        if right_sides.ndim == 1:
            return self._solve_one(right_sides.astype(self._number)).astype(np.float64)
        return self._solve_some(right_sides.astype(self._number)).astype(np.float64)

    def _factor(self, values: FloatArray, shift: float) -> None:
        if self._store is None:
            self._make_store()
        self._store.fill(0.0)
        self._store[self._plan.indices] = values
        self._store[self._diagonal] *= 1.0 + shift
        for front, (pivots, panel, left) in zip(self._plan.fronts, self._blocks, strict=True):
            for child in front.children:
                self._add(front, child, 0, self._plan.own_columns[child])
            _, failed = self._potrf(pivots, lower=1, clean=0, overwrite_a=1)
            if failed:
                raise NotPositiveDefiniteError(f'pivot {failed} of {len(front.own)} in a front')
            if not len(front.border):
                continue
            self._divide(panel, pivots, 0, len(front.own))
            self._syrk(-1.0, panel, beta=0.0, c=left, lower=1, overwrite_c=1)
            for child in front.children:
                self._add(front, child, self._plan.own_columns[child], None)

    def _divide(self, panel: NDArray[Any], pivots: NDArray[Any], start: int, end: int) -> None:
        """Solve X L^T = panel in place for columns: products are twice as fast as `trsm`."""
        if end - start <= _DIVIDED_AT_ONCE:
            inverse, _ = self._trtri(pivots[start:end, start:end], lower=1)
            columns = panel[:, start:end]
            self._trmm(1.0, inverse, columns, side=1, lower=1, trans_a=1, overwrite_b=1)
            return
        middle = (start + end) // 2
        self._divide(panel, pivots, start, middle)
        self._gemm(
            -1.0,
            panel[:, start:middle],
            pivots[middle:end, start:middle],
            trans_b=1,
            beta=1.0,
            c=panel[:, middle:end],
            overwrite_c=1,
        )
        self._divide(panel, pivots, middle, end)

    def _add(self, front: Front, child: int, first: int, end: int | None) -> None:
        """Add columns of what a child left to a front; None: all from the first one on."""
        size = len(self._plan.fronts[child].border)
        self._which_numbers[:] = child, first, size if end is None else end
        self._launchers[front.stack].launch(
            self._add_columns,
            1,
            [self._which, self._width, self._table, self._into, self._stacks[1 - front.stack]],
            [self._store_by_nodes, self._stacks[front.stack]],
        )

    def _make_store(self) -> None:
        # Kept, for the system takes long to give memory anew.
        self._store = np.empty(self._plan.store_size, dtype=self._number)
        stacks = [np.empty(size, dtype=self._number) for size in self._plan.stack_sizes]
        self._store_by_nodes = self._by_nodes(self._store)
        self._stacks = [self._by_nodes(stack) for stack in stacks]
        for front in self._plan.fronts:
            n, m = len(front.own), len(front.border)
            self._blocks.append(
                _Block(
                    pivots=_matrix(self._store, front.pivots, n, n),
                    panel=_matrix(self._store, front.panel, m, n),
                    left=_matrix(stacks[front.stack], front.update, m, m),
                )
            )

    def _by_nodes(self, numbers: NDArray[Any]) -> Any:
        """Look at memory as a Warp array of the numbers of one node each."""
        shape = (len(numbers) // self._width.value, self._width.value)
        by_nodes = numbers if shape[1] == 1 else numbers.reshape(shape)
        return wp.array(by_nodes, dtype=self._entry, copy=False, device='cpu')

    def _solve_one(self, x: NDArray[Any]) -> NDArray[Any]:
        """Solve in place, shape (n,)."""
        for front, (pivots, panel, _) in zip(self._plan.fronts, self._blocks, strict=True):
            own = self._trsv(pivots, x[front.own], lower=1, overwrite_x=1)
            x[front.own] = own
            x[front.border] -= panel @ own
        for front, (pivots, panel, _) in zip(
            reversed(self._plan.fronts), reversed(self._blocks), strict=True
        ):
            own = x[front.own] - x[front.border] @ panel
            x[front.own] = self._trsv(pivots, own, lower=1, trans=1, overwrite_x=1)
        return x

    def _solve_some(self, x: NDArray[Any]) -> NDArray[Any]:
        """Solve in place, shape (n, k)."""
        for front, (pivots, panel, _) in zip(self._plan.fronts, self._blocks, strict=True):
            own = self._trsm(1.0, pivots, x[front.own], lower=1)
            x[front.own] = own
            x[front.border] -= panel @ own
        for front, (pivots, panel, _) in zip(
            reversed(self._plan.fronts), reversed(self._blocks), strict=True
        ):
            own = x[front.own] - panel.T @ x[front.border]
            x[front.own] = self._trsm(1.0, pivots, own, lower=1, trans_a=1)
        return x


def _matrix(numbers: NDArray[Any], start: int, rows: int, columns: int) -> NDArray[Any]:
    """Look at a part of memory as a matrix by columns."""
    return numbers[start : start + rows * columns].reshape((rows, columns), order='F')
