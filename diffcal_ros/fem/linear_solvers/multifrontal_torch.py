# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Multifrontal Cholesky on a GPU: the fronts of `multifrontal` in PyTorch's dense algebra.

A front is a few calls of cuSOLVER and cuBLAS, and what it leaves goes to its parent on the device.
PyTorch's CPU does the same, which is how this is tested where there is no GPU.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.linear_solvers.frontal_kernels import add_update
from diffcal_ros.fem.linear_solvers.frontal_plan import Front, make_plan
from diffcal_ros.fem.linear_solvers.interface import NotPositiveDefiniteError
from diffcal_ros.warp_runtime.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
import torch
import warp as wp

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class _Block:
    """A front's factors on the device, and where its unknowns are in the order of elimination."""

    pivots: torch.Tensor  # (n, n), lower triangle
    panel: torch.Tensor  # (m, n)
    left: torch.Tensor  # (m, m), what is added to the parent
    own: slice
    border: torch.Tensor  # (m,)


class TorchMultifrontalSolver:
    """Cholesky factorisation in double precision along a nested dissection, on any device."""

    name = 'multifrontal_torch'
    few_sides = 0
    patience = 5
    is_exact = True

    def __init__(self, pattern: SparsePattern, device: str = 'cpu') -> None:
        """Lay out the factors.

        Args:
            pattern: where the entries are.
            device: Warp's and PyTorch's name of it, such as `cuda:0`.
        """
        self._plan = make_plan(pattern)
        self._device = torch.device(device)
        self._launcher = Launcher(device)
        self._order = np.concatenate([front.own for front in self._plan.fronts])
        self._blocks: list[_Block] = []
        self._store = torch.empty(0)
        self._side = torch.empty(0)
        self._recorded: torch.cuda.CUDAGraph | None = None

    def factor(self, values: FloatArray) -> None:
        """Factor; see `SparseSolver`."""
        if not self._blocks:
            self._lay_out_on_device()
        self._store.zero_()
        self._store[self._indices] = torch.from_numpy(values).to(self._device)
        with self._one_stream():
            for number, (front, block) in enumerate(
                zip(self._plan.fronts, self._blocks, strict=True)
            ):
                self._eliminate(number, front, block)
        # Asked for once: each answer would wait for all that the device has been given to do.
        failed = int((self._failed != 0).sum())
        if failed:
            raise NotPositiveDefiniteError(f'{failed} of {len(self._blocks)} fronts')

    def solve(self, right_sides: FloatArray) -> FloatArray:
        """Solve; see `SparseSolver`."""
        sides = right_sides.reshape(len(right_sides), -1)[self._order].astype(np.float64)
        x = torch.from_numpy(sides).to(self._device)
        if self._device.type == 'cuda' and sides.shape[1] == 1:
            x = self._solve_recorded(x)
        else:
            self._solve_in_place(x)
        solution = np.empty_like(sides)
        solution[self._order] = x.cpu().numpy()
        return solution.reshape(right_sides.shape)

    def _solve_recorded(self, x: torch.Tensor) -> torch.Tensor:
        """Solve for one side as recorded: a launch takes longer than most of these kernels run."""
        if self._recorded is None:
            self._side = torch.zeros_like(x)
            # Libraries take their memory at their first call, which must not be recorded.
            make_stream: Any = torch.cuda.Stream
            warm_up = make_stream(self._device)
            warm_up.wait_stream(torch.cuda.current_stream(self._device))
            with torch.cuda.stream(warm_up):
                self._solve_in_place(self._side)
            torch.cuda.current_stream(self._device).wait_stream(warm_up)
            self._recorded = torch.cuda.CUDAGraph()
            # Other bodies may be settled in other threads meanwhile.
            with torch.cuda.graph(self._recorded, capture_error_mode='thread_local'):
                self._solve_in_place(self._side)
        self._side.copy_(x)
        self._recorded.replay()
        return self._side

    def _solve_in_place(self, x: torch.Tensor) -> None:
        """Solve for x in the order of elimination, shape (n, k)."""
        for block in self._blocks:
            own = torch.linalg.solve_triangular(block.pivots, x[block.own], upper=False)
            x[block.own] = own
            if len(block.border):
                x.index_add_(0, block.border, block.panel @ own, alpha=-1.0)
        for block in reversed(self._blocks):
            own = x[block.own]
            if len(block.border):
                own = own - block.panel.mT @ x[block.border]
            x[block.own] = torch.linalg.solve_triangular(block.pivots.mT, own, upper=True)

    def _eliminate(self, number: int, front: Front, block: _Block) -> None:
        """Add what the children left to a front, and factor it."""
        block.left.zero_()
        for child in front.children:
            self._launcher.launch(
                add_update,
                len(self._plan.fronts[child].border),
                [child, self._table, self._into, self._stacks[1 - front.stack]],
                [self._store_for_warp, self._stacks[front.stack]],
            )
        factor, failed = torch.linalg.cholesky_ex(block.pivots)
        block.pivots.copy_(factor)
        self._failed[number] = failed
        if len(front.border):
            block.panel.copy_(
                torch.linalg.solve_triangular(factor.mT, block.panel, upper=True, left=False)
            )
            block.left.addmm_(block.panel, block.panel.mT, alpha=-1.0)

    def _lay_out_on_device(self) -> None:
        plan, device = self._plan, self._device
        try:
            self._store = torch.zeros(plan.store_size, dtype=torch.float64, device=device)
            stacks = [
                torch.zeros(max(size, 1), dtype=torch.float64, device=device)
                for size in plan.stack_sizes
            ]
        except torch.OutOfMemoryError as error:
            needed = 8e-9 * (plan.store_size + sum(plan.stack_sizes))
            raise InputError(
                f'the factors of {len(self._order):,} unknowns take {needed:.1f} GB, which '
                f'{device} does not have free: use a coarser mesh, or device cpu'
            ) from error
        self._indices = torch.from_numpy(plan.indices).to(device).long()
        self._failed = torch.zeros(len(plan.fronts), dtype=torch.int32, device=device)
        # Warp's arrays look at the same memory.
        self._store_for_warp = wp.from_torch(self._store, dtype=wp.float64)
        self._stacks = [wp.from_torch(stack, dtype=wp.float64) for stack in stacks]
        self._table, self._into = (
            wp.from_torch(torch.from_numpy(one).to(device), dtype=wp.int32)
            for one in (plan.table, plan.into)
        )
        rank = np.empty_like(self._order)
        rank[self._order] = np.arange(len(rank))
        start = 0
        for front in plan.fronts:
            end = start + len(front.own)
            self._blocks.append(self._block(front, slice(start, end), rank, stacks))
            start = end

    def _block(
        self, front: Front, own: slice, rank: NDArray[np.int64], stacks: list[torch.Tensor]
    ) -> _Block:
        n, m = len(front.own), len(front.border)
        # By columns, so transposed.
        return _Block(
            pivots=self._store[front.pivots : front.pivots + n * n].view(n, n).mT,
            panel=self._store[front.panel : front.panel + n * m].view(n, m).mT,
            left=stacks[front.stack][front.update : front.update + m * m].view(m, m).mT,
            own=own,
            border=torch.from_numpy(rank[front.border]).to(self._device),
        )

    @contextmanager
    def _one_stream(self) -> Iterator[None]:
        """Let Warp's kernels run in order with PyTorch's."""
        if self._device.type != 'cuda':
            yield
            return
        stream: Any = wp.stream_from_torch(torch.cuda.current_stream(self._device))
        with wp.ScopedStream(stream):
            yield
