# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Nested dissection (George 1973) of a mesh's nodes, by where they are.

A set of nodes is halved across its length, and the least set of nodes that parts the halves is
eliminated after both. That set is a smallest vertex cover of the edges that cross the cut, which
König's theorem reads off a largest matching of them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, maximum_bipartite_matching

FloatArray = NDArray[np.float64]
LongArray = NDArray[np.int64]

# A dense matrix of so many nodes costs no more than its parts.
_LEAF_SIZE = 40
# In larger sets a cut across each of the three axes is tried: a smaller separator pays.
_TRIED_FROM = 1000


@dataclass(frozen=True)
class Dissection:
    """Groups of nodes in the order of their elimination, children before parents.

    Attributes:
        groups: nodes of each group.
        parents: group into which each group's elimination leads, -1 for a last one.
    """

    groups: list[LongArray]
    parents: list[int]


def dissect(graph: csr_matrix, positions: FloatArray, leaf_size: int = _LEAF_SIZE) -> Dissection:
    """Part a graph until its pieces are small.

    Args:
        graph: which nodes are joined, both ways and without themselves, shape (M, M).
        positions: of the nodes [m], shape (M, 3); neighbours should be close to each other.
        leaf_size: nodes of a piece that is parted no further.
    """
    groups: list[LongArray] = []
    children: list[tuple[int, ...]] = []

    def part(nodes: LongArray, edges: csr_matrix) -> tuple[int, ...]:
        if len(nodes) <= leaf_size:
            below: tuple[int, ...] = ()
            own = nodes
        else:
            side = _best_cut(edges, positions[nodes])
            first, second = np.flatnonzero(side == 0), np.flatnonzero(side == 1)
            below = part(nodes[first], _within(edges, first))
            below += part(nodes[second], _within(edges, second))
            own = nodes[side == 2]
        if len(own) == 0:
            return below
        groups.append(own)
        children.append(below)
        return (len(groups) - 1,)

    part(np.arange(len(positions)), graph)
    parents = [-1] * len(groups)
    for parent, below in enumerate(children):
        for child in below:
            parents[child] = parent
    return Dissection(groups, parents)


def _within(edges: csr_matrix, kept: LongArray) -> csr_matrix:
    """Return the graph between some of its nodes."""
    return edges[kept][:, kept]


def _best_cut(edges: csr_matrix, positions: FloatArray) -> NDArray[np.int8]:
    """Tell the side of each node, 0 or 1, and 2 for the separator."""
    _, axes = np.linalg.eigh(np.cov(positions.T))
    count = 3 if len(positions) >= _TRIED_FROM else 1
    cuts = [_cut(edges, positions @ axis) for axis in axes.T[::-1][:count]]
    return min(cuts, key=_cost)


def _cost(side: NDArray[np.int8]) -> float:
    """Weigh a separator's size against how unequal the halves are."""
    first, second, between = (float((side == value).sum()) for value in range(3))
    return between * (1.0 + abs(first - second) / (first + second + between))


def _cut(edges: csr_matrix, height: FloatArray) -> NDArray[np.int8]:
    """Part nodes at the median of their heights, shape (m,)."""
    order = np.argsort(height, kind='stable')
    side = np.zeros(len(height), dtype=np.int8)
    side[order[len(order) // 2 :]] = 1
    first = np.flatnonzero(side == 0)
    crossing = edges[first].tocoo()
    is_crossing = side[crossing.col] == 1
    low, high = first[crossing.row[is_crossing]], crossing.col[is_crossing]
    if len(low):
        side[_vertex_cover(low, high)] = 2
    return side


def _vertex_cover(low: LongArray, high: LongArray) -> LongArray:
    """Return the fewest nodes that touch every edge low-high of a bipartite graph."""
    left, row = np.unique(low, return_inverse=True)
    right, column = np.unique(high, return_inverse=True)
    ones = np.ones(len(row), dtype=np.int8)
    bipartite = csr_matrix((ones, (row, column)), shape=(len(left), len(right)))
    partner = maximum_bipartite_matching(bipartite, perm_type='row')  # Of each right node.
    is_matched = np.zeros(len(left), dtype=bool)
    is_matched[partner[partner >= 0]] = True
    # Alternating paths from unmatched left nodes: any edge to the right, a matched one back.
    unmatched = np.flatnonzero(~is_matched)
    matched_right = np.flatnonzero(partner >= 0)
    source = len(left) + len(right)
    start = np.concatenate([row, len(left) + matched_right, np.full(len(unmatched), source)])
    end = np.concatenate([len(left) + column, partner[matched_right], unmatched])
    paths = csr_matrix((np.ones(len(start), dtype=np.int8), (start, end)), shape=(source + 1,) * 2)
    is_reached = np.zeros(source + 1, dtype=bool)
    is_reached[breadth_first_order(paths, source, return_predecessors=False)] = True
    return np.concatenate([left[~is_reached[: len(left)]], right[is_reached[len(left) : source]]])
