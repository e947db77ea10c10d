# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an elimination order must keep: every node once, and branches that do not touch."""

from diffcal_ros.fem.elements import nested_dissection
from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.nested_dissection import dissect
from diffcal_ros.fem.elements.sparse_pattern import make_pattern, SparsePattern
import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import maximum_bipartite_matching
from support.beams import beam_mesh, held_end


def _pattern() -> SparsePattern:
    mesh = beam_mesh((7, 4, 3), (0.09, 0.05, 0.02))
    body = discretise(mesh, Element.QUADRATIC)
    # A cable from one end to the other joins nodes that are far from each other.
    cable = [body.nodes[0], body.nodes[len(body.nodes) // 2], body.nodes[-1]]
    return make_pattern(body, held_end(mesh), coupled_nodes=[np.concatenate(cable)])


@pytest.mark.parametrize('leaf_size', [1, 7, 40, 10_000])
def test_only_a_group_and_those_it_leads_to_touch(leaf_size) -> None:
    pattern = _pattern()
    found = dissect(pattern.graph, pattern.layout, leaf_size)
    nodes = np.concatenate(found.groups)
    np.testing.assert_array_equal(np.sort(nodes), np.arange(len(pattern.free_nodes)))
    group_of = np.empty(len(nodes), dtype=int)
    group_of[nodes] = np.repeat(np.arange(len(found.groups)), [len(g) for g in found.groups])
    count = len(found.groups)
    leads_to = np.eye(count, dtype=bool)
    parents = np.array(found.parents)
    assert ((parents > np.arange(count)) | (parents == -1)).all()
    for group in np.flatnonzero(parents >= 0)[::-1]:
        leads_to[group] |= leads_to[parents[group]]
    edges = pattern.graph.tocoo()
    first, second = group_of[edges.row], group_of[edges.col]
    assert (leads_to[first, second] | leads_to[second, first]).all()


@pytest.mark.parametrize('density', [0.05, 0.2, 0.6])
def test_a_cover_touches_every_edge_and_is_as_small_as_a_matching(density, random) -> None:
    joined = random.uniform(size=(17, 23)) < density
    low, high = np.nonzero(joined)
    cover = nested_dissection._vertex_cover(low, high + 100)
    assert (np.isin(low, cover) | np.isin(high + 100, cover)).all()
    matching = maximum_bipartite_matching(csr_matrix(joined), perm_type='row')
    assert len(cover) == (matching >= 0).sum()  # König: no cover is smaller.


def test_a_long_body_is_cut_across() -> None:
    mesh = beam_mesh((24, 3, 3), (0.24, 0.03, 0.03))
    pattern = make_pattern(discretise(mesh, Element.LINEAR), held_end(mesh))
    last = dissect(pattern.graph, pattern.layout, 40).groups[-1]
    assert len(last) == 16  # One cross-section of 4 x 4 nodes.
