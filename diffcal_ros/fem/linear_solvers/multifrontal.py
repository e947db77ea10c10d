# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Multifrontal Cholesky (Duff and Reid 1983) on the BLAS that SciPy brings along.

Unknowns are eliminated in groups, each in a dense matrix, so that nearly all the work is products
of dense matrices. Factors of large bodies are kept in single precision, which takes half the
memory and two thirds of the time; conjugate gradients with them gain two digits an iteration.
"""

import ctypes
from functools import cached_property
from typing import Any

from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.frontal_plan import make_plan
from diffcal_ros.fem.linear_solvers.frontal_routines import AT_ONCE, frontal_kernel, Given, Task
from diffcal_ros.fem.linear_solvers.interface import NotPositiveDefiniteError
from diffcal_ros.warp_runtime.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
import warp as wp

FloatArray = NDArray[np.float64]

# Factors with more numbers are kept in single precision: 25,000 quadratic tetrahedra.
_DOUBLE_LIMIT = 60_000_000
# Where rounding to single precision leaves a negative pivot, the diagonal grows by such a share.
_SINGLE_SHIFT = 1e-5
# Operations after which whoever waits is heard: a tenth of a second.
_AT_A_TIME = 4e9


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
        self._plan = plan = make_plan(pattern, per_node)
        self.is_exact = plan.store_size < _DOUBLE_LIMIT if is_exact is None else is_exact
        # A factorisation costs the more beside a solution the larger the body is.
        self.few_sides, self.patience = (0, 10) if self.is_exact else (1, 15)
        self._diagonal = pattern.diagonal_slots if per_node == 3 else pattern.block_starts[:-1]
        self._number: Any = np.float64 if self.is_exact else np.float32
        self._kernel = frontal_kernel(self._number)
        self._launcher = Launcher('cpu')
        self._largest = max(len(front.own) + len(front.border) for front in plan.fronts)
        self._arrays: dict[str, NDArray[Any]] = {}
        self._given = Given(width=per_node)
        self._given.find_routines(self._number)
        self._address = wp.uint64(ctypes.addressof(self._given))
        self._give(
            table=plan.table,
            children=plan.children,
            unknowns=plan.unknowns,
            into=np.ascontiguousarray(plan.into[::per_node] // per_node),
            scratch=np.empty(max(self._largest, AT_ONCE**2), dtype=self._number),
        )

    def factor(self, values: FloatArray) -> None:
        """Factor; see `SparseSolver`."""
        try:
            self._factor(values)
        except NotPositiveDefiniteError:
            if self.is_exact:
                raise
            shifted = values.copy()
            shifted[self._diagonal] *= 1.0 + _SINGLE_SHIFT
            self._factor(shifted)

    def finish(self) -> None:
        """Free what another factorisation would need: this matrix stays the last one."""
        nothing = np.empty(0, dtype=self._number)
        self._give(stack_0=nothing, stack_1=nothing)

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve; see `SparseSolver`."""
        # A copy: it is solved in place.
        x = np.array(right_sides, dtype=self._number, order='C')
        if not x.size:
            return x.astype(np.float64, copy=False)
        self._given.sides = sides = x.size // len(x)
        if len(self._arrays['scratch']) < sides * self._largest:
            self._give(scratch=np.empty(sides * self._largest, dtype=self._number))
        self._given.x = x.ctypes.data
        task = Task.SOLVE_ONE if right_sides.ndim == 1 else Task.SOLVE_SOME
        self._do(task, 0, len(self._plan.fronts))
        return x.astype(np.float64, copy=False)

    def _factor(self, values: FloatArray) -> None:
        store = self._arrays.get('store')
        if store is None:
            # Kept, for the system takes long to give memory anew.
            store = np.empty(self._plan.store_size, dtype=self._number)
            stacks = [np.empty(size, dtype=self._number) for size in self._plan.stack_sizes]
            self._give(store=store, stack_0=stacks[0], stack_1=stacks[1])
        store.fill(0.0)
        store[self._plan.indices] = values
        self._given.failed = 0
        for first, end in self._spans:
            self._do(Task.FACTOR, first, end)
            if self._given.failed:
                count = len(self._plan.fronts[self._given.place].own)
                raise NotPositiveDefiniteError(f'pivot {self._given.failed} of {count} in a front')

    @cached_property
    def _spans(self) -> list[tuple[int, int]]:
        """Fronts to eliminate in one call: between two of them signals are heard."""
        n, m = self._plan.table[:-1, 1:3].T.astype(np.float64)
        spent = np.cumsum(n * (n + m) ** 2)
        ends = np.searchsorted(spent, np.arange(_AT_A_TIME, spent[-1], _AT_A_TIME)) + 1
        borders = np.unique([0, *ends, len(n)])
        return list(zip(borders[:-1].tolist(), borders[1:].tolist(), strict=True))

    def _do(self, task: Task, first: int, end: int) -> None:
        """Do a task on some fronts."""
        self._given.task, self._given.first, self._given.end = task, first, end
        self._launcher.launch(self._kernel, 1, [self._address], [])

    def _give(self, **arrays: NDArray[Any]) -> None:
        """Tell the compiled code where arrays are, and keep them."""
        self._arrays.update(arrays)
        for name, array in arrays.items():
            setattr(self._given, name, array.ctypes.data)
