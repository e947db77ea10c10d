# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fixed sparsity pattern of the stiffness and the place of every element entry in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
import hashlib
from typing import Any
from weakref import WeakValueDictionary

from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.elements.nested_dissection import dissect, Dissection
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, csr_matrix

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class SparsePattern:
    """Lower triangle by columns (equally: upper triangle by rows) of a symmetric matrix.

    Unknowns are the three coordinates of each free node, in the order of the free nodes.

    Attributes:
        free_nodes: node indices, shape (M,).
        column_starts: shape (3 M + 1,).
        row_indices: ascending within a column, diagonal first, shape (nnz,).
        slots: place of each entry of each element block, -1 where it is held or belongs to the
            other triangle, shape (T, pairs, 9). Pairs run over nodes a <= b of a tetrahedron.
        layout: of the free nodes, see `Discretisation` [m], shape (M, 3).
        block_starts: first of each free node's blocks in `neighbours`, shape (M + 1,).
        neighbours: number of the free node that each block joins it to: itself first, then
            ascending, higher ones only.
    """

    free_nodes: IntArray
    column_starts: IntArray
    row_indices: IntArray
    slots: IntArray
    layout: FloatArray
    block_starts: IntArray
    neighbours: IntArray

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.column_starts) - 1

    @property
    def entry_count(self) -> int:
        """Number of stored entries."""
        return len(self.row_indices)

    def times(self, values: FloatArray, vector: FloatArray) -> FloatArray:
        """Multiply the matrix with these entries, shape (nnz,), and a vector, shape (3 M,)."""
        parts = (values, self.row_indices, self.column_starts)
        lower = csc_matrix(parts, shape=(self.size, self.size), copy=False)
        upper = csr_matrix(parts, shape=(self.size, self.size), copy=False)
        result: FloatArray = lower @ vector + upper @ vector
        return result - values[self.diagonal_slots] * vector

    @cached_property
    def graph(self) -> csr_matrix:
        """Which free nodes are joined, both ways and without themselves, shape (M, M)."""
        count = len(self.free_nodes)
        owner = np.repeat(np.arange(count), np.diff(self.block_starts))
        is_other = owner != self.neighbours
        low, high = owner[is_other], self.neighbours[is_other]
        ones = np.ones(2 * len(low), dtype=np.int8)
        ends = np.concatenate([low, high]), np.concatenate([high, low])
        return csr_matrix((ones, ends), shape=(count, count))

    @cached_property
    def dissection(self) -> Dissection:
        """An order in which to eliminate the free nodes."""
        return dissect(self.graph, self.layout)

    @cached_property
    def diagonal_slots(self) -> IntArray:
        """Places of the diagonal, shape (3 M,)."""
        return self.column_starts[:-1]


# Patterns that bodies have at present: those of one mesh that is held alike, wherever it stands,
# share one, and what is found for it.
_known: 'WeakValueDictionary[bytes, SparsePattern]' = WeakValueDictionary()


def make_pattern(
    discretisation: Discretisation,
    held_nodes: IntArray,
    *,
    coupled_nodes: Sequence[NDArray[np.integer]] = (),
) -> SparsePattern:
    """Find the pattern of the free nodes' stiffness.

    Args:
        discretisation: elements, each of which couples its nodes.
        held_nodes: that are no unknowns, shape (h,).
        coupled_nodes: groups of nodes that something else couples, each with each.
    """
    key = _digest(discretisation, held_nodes, coupled_nodes)
    found = _known.get(key)
    if found is None:
        found = _known[key] = _new_pattern(discretisation, held_nodes, coupled_nodes)
    return found


def _digest(
    discretisation: Discretisation,
    held_nodes: IntArray,
    coupled_nodes: Sequence[NDArray[np.integer]],
) -> bytes:
    """Return what tells a pattern from others: all that it is made of."""
    made = hashlib.blake2b()
    parts: list[NDArray[Any]] = [discretisation.nodes, discretisation.layout, held_nodes]
    for part in (*parts, *coupled_nodes):
        made.update(f'{part.dtype}{part.shape}'.encode())
        made.update(np.ascontiguousarray(part).tobytes())
    return made.digest()


def _new_pattern(
    discretisation: Discretisation,
    held_nodes: IntArray,
    coupled_nodes: Sequence[NDArray[np.integer]],
) -> SparsePattern:
    nodes = discretisation.nodes
    is_free = np.ones(discretisation.node_count, dtype=bool)
    is_free[held_nodes] = False
    free_nodes = np.flatnonzero(is_free).astype(np.int32)
    number = np.full(discretisation.node_count, -1, dtype=np.int64)
    number[free_nodes] = np.arange(len(free_nodes))

    first, second = np.triu_indices(nodes.shape[1])
    a, b = number[nodes[:, first]], number[nodes[:, second]]
    low, high = np.minimum(a, b), np.maximum(a, b)
    both_free = low >= 0
    keys = low * len(free_nodes) + high
    more = [_pair_keys(number[group], len(free_nodes)) for group in coupled_nodes]
    unique, position = np.unique(np.concatenate([keys[both_free], *more]), return_inverse=True)
    position = position[: int(both_free.sum())]
    owner, neighbour = np.divmod(unique, max(len(free_nodes), 1))

    block_counts = np.bincount(owner, minlength=len(free_nodes))
    block_starts = np.concatenate([[0], np.cumsum(block_counts)])
    column_starts = _column_starts(block_counts)
    pair_slots = _pair_slots(owner, block_starts, column_starts)

    slots = np.full((*low.shape, 3, 3), -1, dtype=np.int32)  # [i of a, j of b]
    found = pair_slots[position]
    turned = (a > b)[both_free]
    found[turned] = found[turned].transpose(0, 2, 1)
    slots[both_free] = found
    return SparsePattern(
        free_nodes=free_nodes,
        column_starts=column_starts.astype(np.int32),
        row_indices=_row_indices(pair_slots, neighbour, int(column_starts[-1])),
        slots=slots.reshape(*low.shape, 9),
        layout=discretisation.layout[free_nodes],
        block_starts=block_starts.astype(np.int32),
        neighbours=neighbour.astype(np.int32),
    )


def _column_starts(block_counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return where each column begins in the stored values, and their number, (3 M + 1,).

    Column c of a node holds 3 - c entries of its own block, then 3 of each neighbour.
    """
    column_sizes = (3 - np.arange(3))[None, :] + 3 * (block_counts - 1)[:, None]
    return np.concatenate([[0], np.cumsum(column_sizes.ravel())])


def _pair_slots(
    owner: NDArray[np.int64], block_starts: NDArray[np.int64], column_starts: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return where the entries of each pair of nodes are stored, (P, 3, 3): [column c, row r].

    Those of a node with itself above the diagonal are not: -1.
    """
    rank = np.arange(len(owner)) - block_starts[owner]
    slots = np.full((len(owner), 3, 3), -1, dtype=np.int64)
    for c in range(3):
        start = column_starts[3 * owner + c]
        for r in range(3):
            diagonal = np.where(r >= c, start + r - c, -1)
            slots[:, c, r] = np.where(rank == 0, diagonal, start + 3 * rank - c + r)
    return slots


def _row_indices(
    pair_slots: NDArray[np.int64], neighbour: NDArray[np.int64], count: int
) -> NDArray[np.int32]:
    """Return the row of each stored entry, shape (count,)."""
    rows = np.empty(count, dtype=np.int32)
    for r in range(3):
        for c in range(3):
            stored = pair_slots[:, c, r] >= 0
            rows[pair_slots[stored, c, r]] = 3 * neighbour[stored] + r
    return rows


def _pair_keys(numbers: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return the key of each pair of free nodes in a group; -1 numbers are held."""
    free = np.unique(numbers[numbers >= 0])
    first, second = np.triu_indices(len(free))
    keys: NDArray[np.int64] = free[first] * count + free[second]
    return keys
