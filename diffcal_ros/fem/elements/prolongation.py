# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Finer discretisations of the same body, and how a coarse solution looks on them."""

from dataclasses import dataclass

from diffcal_ros.fem.elements.element import Discretisation, discretise, Element
from diffcal_ros.tet_mesh import TET_EDGES, TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class Enrichment:
    """A finer discretisation that contains the coarse one.

    Attributes:
        fine: the finer one.
        fine_from_coarse: interpolation of nodal values, shape (N_fine, N_coarse).
        parents: coarse tetrahedron of each fine one.
    """

    fine: Discretisation
    fine_from_coarse: csr_matrix
    parents: IntArray


def refine(mesh: TetMesh, coarse: Discretisation) -> Enrichment:
    """Halve the mesh size of quadratic elements.

    Raises:
        ValueError: for another element.
    """
    if coarse.element is not Element.QUADRATIC:
        raise ValueError(
            f'{coarse.element.value} elements are not refined here: use quadratic ones'
        )
    finer_mesh, parents = mesh.refined()
    fine = discretise(finer_mesh, Element.QUADRATIC)
    return Enrichment(fine, _interpolation(mesh, coarse, finer_mesh, fine, parents), parents)


def _interpolation(
    mesh: TetMesh,
    coarse: Discretisation,
    finer_mesh: TetMesh,
    fine: Discretisation,
    parents: IntArray,
) -> csr_matrix:
    """Evaluate the coarse quadratic shape functions at the fine nodes."""
    # Any tetrahedron that holds a fine node will do: the shape functions agree on shared faces.
    index = np.empty(fine.node_count, dtype=np.int64)
    index[fine.nodes.ravel()] = np.arange(fine.nodes.size)
    owner = parents[index // fine.nodes.shape[1]]
    corners = mesh.rest_positions[mesh.tets[owner]]
    offset = fine.rest_nodes - corners[:, 0]
    matrix = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    last = np.linalg.solve(matrix, offset[..., None])[..., 0]
    barycentric = np.concatenate([1.0 - last.sum(axis=1, keepdims=True), last], axis=1)
    # Coordinates of refined nodes are multiples of a quarter: rounding makes held nodes exact.
    barycentric = np.round(4.0 * barycentric) / 4.0
    values = np.hstack(
        [
            barycentric * (2.0 * barycentric - 1.0),
            4.0 * barycentric[:, TET_EDGES[:, 0]] * barycentric[:, TET_EDGES[:, 1]],
        ]
    )
    rows = np.repeat(np.arange(fine.node_count), 10)
    matrix = csr_matrix(
        (values.ravel(), (rows, coarse.nodes[owner].ravel())),
        shape=(fine.node_count, coarse.node_count),
    )
    matrix.eliminate_zeros()
    return matrix
