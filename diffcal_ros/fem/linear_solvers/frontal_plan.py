# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where every number goes in a multifrontal factorisation, found once for a pattern."""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

from diffcal_ros.fem.elements.nested_dissection import Dissection
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

LongArray = NDArray[np.int64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class Front:
    """A dense matrix of the unknowns that one group eliminates and of those they lead to.

    Attributes:
        own: unknowns that are eliminated here, shape (n,).
        border: unknowns of later groups that they are joined to, shape (m,).
        pivots: start of the n x n factor of `own` in the store.
        panel: start of the m x n factor of `border` in the store; both by columns.
        update: start of the m x m matrix that is left, on one of two stacks.
        stack: which: children wait on the other one.
        children: fronts whose left matrices are added here.
    """

    own: LongArray
    border: LongArray
    pivots: int
    panel: int
    update: int
    stack: int
    children: tuple[int, ...]


@dataclass(frozen=True)
class FrontalPlan:
    """The fronts of one pattern.

    Attributes:
        fronts: children before parents.
        table: of each front its parent, n, m, where its places begin in `into`, `update`,
            `pivots`, `panel` and `stack`, see `Front`, how many of its border are its parent's
            own, and where it begins in `children` and in `unknowns`; one row more, which ends
            these; shape (fronts + 1, 11).
        into: places of each front's border among its parent's `own` and `border`.
        children: of each front, those of all one after the other.
        unknowns: of each front its own, then its border, those of all one after the other.
        store_size: numbers of all factors.
        stack_sizes: numbers that wait at most on each stack.
        indices: of the pattern's entries in the store, shape (nnz,).
    """

    fronts: tuple[Front, ...]
    table: IntArray
    into: IntArray
    children: IntArray
    unknowns: IntArray
    store_size: int
    stack_sizes: tuple[int, int]
    indices: IntArray


# Plans of patterns that bodies have at present, by unknowns of each node.
_known: 'WeakKeyDictionary[SparsePattern, dict[int, FrontalPlan]]' = WeakKeyDictionary()


def make_plan(pattern: SparsePattern, per_node: int = 3) -> FrontalPlan:
    """Lay out the fronts of a pattern's dissection, or find them as they were laid out.

    Args:
        pattern: of the matrix.
        per_node: unknowns of each node, ordered as in the pattern; with one, the matrix has one
            entry for each of the pattern's blocks.
    """
    plans = _known.setdefault(pattern, {})
    if per_node not in plans:
        plans[per_node] = _new_plan(pattern, per_node)
    return plans[per_node]


def _new_plan(pattern: SparsePattern, per_node: int) -> FrontalPlan:
    dissection = pattern.dissection
    order = np.concatenate(dissection.groups)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    ends = np.cumsum([len(group) for group in dissection.groups])
    borders = _borders(pattern.graph[order][:, order], ends, dissection.parents)
    fronts, stack_sizes = _lay_out(dissection, order, borders, per_node)
    into = [
        _indices_in_parent(borders, ends, child, parent, per_node)
        for child, parent in enumerate(dissection.parents)
    ]
    unknowns = [np.concatenate([front.own, front.border]) for front in fronts]
    last = fronts[-1]
    return FrontalPlan(
        fronts=fronts,
        table=_table(fronts, dissection.parents, into),
        into=np.concatenate(into).astype(np.int32),
        children=np.array([c for front in fronts for c in front.children], dtype=np.int32),
        unknowns=np.concatenate(unknowns).astype(np.int32),
        store_size=last.panel + len(last.own) * len(last.border),
        stack_sizes=stack_sizes,
        # Numbers past 32 bits would not fit into `table` either.
        indices=_entry_indices(pattern, rank, ends, borders, fronts, per_node).astype(np.int32),
    )


def _table(fronts: tuple[Front, ...], parents: list[int], into: list[LongArray]) -> IntArray:
    """Return the table of a plan."""
    own_columns = [
        0 if parent < 0 else int(np.searchsorted(places, len(fronts[parent].own)))
        for places, parent in zip(into, parents, strict=True)
    ]
    table = np.zeros((len(fronts) + 1, 11), dtype=np.int32)
    table[:-1, 0], table[:-1, 8] = parents, own_columns
    for column, sizes in {
        3: [len(places) for places in into],
        9: [len(front.children) for front in fronts],
        10: [len(front.own) + len(front.border) for front in fronts],
    }.items():
        table[1:, column] = np.cumsum(sizes)
    for row, f in zip(table, fronts, strict=False):
        row[[1, 2]] = len(f.own), len(f.border)
        row[[4, 5, 6, 7]] = f.update, f.pivots, f.panel, f.stack
    return table


def _borders(graph: csr_matrix, ends: LongArray, parents: list[int]) -> list[LongArray]:
    """Return the later nodes that each group leads to, ascending, by rank."""
    found: list[list[LongArray]] = [[] for _ in ends]
    borders = []
    start = 0
    for number, end in enumerate(ends):
        joined = graph.indices[graph.indptr[start] : graph.indptr[end]].astype(np.int64)
        border = np.unique(np.concatenate([joined, *found[number]]))
        border = border[np.searchsorted(border, end) :]
        borders.append(border)
        found[number] = []
        if parents[number] >= 0:
            found[parents[number]].append(border)
        start = end
    return borders


def _lay_out(
    dissection: Dissection, order: LongArray, borders: list[LongArray], per_node: int
) -> tuple[tuple[Front, ...], tuple[int, int]]:
    """Return the fronts, and the sizes of the stacks."""
    children: list[list[int]] = [[] for _ in borders]
    depths = [0] * len(borders)
    for number, parent in reversed(list(enumerate(dissection.parents))):
        if parent >= 0:
            children[parent].insert(0, number)
            depths[number] = depths[parent] + 1
    fronts: list[Front] = []
    store, tops, sizes = 0, [0, 0], [0, 0]
    for number, (group, border) in enumerate(zip(dissection.groups, borders, strict=True)):
        n, m = per_node * len(group), per_node * len(border)
        stack = depths[number] % 2
        fronts.append(
            Front(
                own=_unknowns(group, per_node),
                border=_unknowns(order[border], per_node),
                pivots=store,
                panel=store + n * n,
                update=tops[stack],
                stack=stack,
                children=tuple(children[number]),
            )
        )
        tops[stack] += m * m
        sizes[stack] = max(sizes[stack], tops[stack])
        if children[number]:
            tops[1 - stack] = fronts[children[number][0]].update
        store += (n + m) * n
    return tuple(fronts), (sizes[0], sizes[1])


def _indices_in_parent(
    borders: list[LongArray], ends: LongArray, child: int, parent: int, per_node: int
) -> LongArray:
    """Return where a front's border unknowns are in its parent, own ones first."""
    if parent < 0:
        return np.zeros(0, dtype=np.int64)
    start, end = ends[parent - 1], ends[parent]
    border = borders[child]
    is_own = border < end
    later = end - start + np.searchsorted(borders[parent], border)
    return _unknowns(np.where(is_own, border - start, later), per_node)


def _unknowns(nodes: LongArray, per_node: int) -> LongArray:
    """Return the unknowns of each node."""
    result: LongArray = (per_node * nodes[:, None] + np.arange(per_node)).ravel()
    return result


def _entry_indices(
    pattern: SparsePattern,
    rank: LongArray,
    ends: LongArray,
    borders: list[LongArray],
    fronts: tuple[Front, ...],
    per_node: int,
) -> LongArray:
    """Return where each entry of the pattern goes in the store."""
    count = len(rank)
    owner = np.repeat(np.arange(count), np.diff(pattern.block_starts))
    first, second = rank[owner], rank[pattern.neighbours]
    is_turned = first > second
    early, late = np.minimum(first, second), np.maximum(first, second)
    front = np.searchsorted(ends, early, side='right')
    starts = np.concatenate([[0], ends[:-1]])
    column = per_node * (early - starts[front])

    border_starts = np.concatenate([[0], np.cumsum([len(b) for b in borders])])
    keys = np.concatenate([b + number * count for number, b in enumerate(borders)])
    in_border = np.searchsorted(keys, late + front * count) - border_starts[front]
    is_own = late < ends[front]
    row = per_node * np.where(is_own, late - starts[front], in_border)
    own_size = per_node * (ends - starts)[front]
    height = np.where(is_own, own_size, per_node * np.diff(border_starts)[front])
    base = np.where(
        is_own,
        np.array([f.pivots for f in fronts])[front],
        np.array([f.panel for f in fronts])[front],
    )
    # Column c of an owner holds as many entries of its own block as are left from there down, then
    # a whole column of each neighbour's.
    blocks = np.diff(pattern.block_starts)
    sizes = per_node * blocks[:, None] - np.arange(per_node)
    starts_of_columns = np.concatenate([[0], np.cumsum(sizes.ravel())])
    of_entry = np.repeat(np.arange(sizes.size), sizes.ravel())
    c = of_entry % per_node
    offset = np.arange(len(of_entry)) - starts_of_columns[of_entry] + c
    block = pattern.block_starts[of_entry // per_node] + offset // per_node
    r = offset % per_node
    down, across = np.where(is_turned[block], c, r), np.where(is_turned[block], r, c)
    indices: LongArray = base[block] + (column[block] + across) * height[block] + row[block] + down
    return indices
