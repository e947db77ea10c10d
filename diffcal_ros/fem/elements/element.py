# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Elements on a tetrahedral mesh: nodes, shape gradients and weights at quadrature points.

`linear` is the 4-node tetrahedron of the paper: cheap, and far too stiff in bending near
nu = 0.5 (volumetric locking). `quadratic` is the 10-node tetrahedron on the same mesh, straight
edges, which does not lock.
"""

from dataclasses import dataclass, replace
from enum import Enum

from diffcal_ros.tet_mesh import TET_EDGES, TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


class Element(str, Enum):
    """Elements by name."""

    LINEAR = 'linear'
    QUADRATIC = 'quadratic'


# The four-point rule, exact for quadratic integrands (Hammer, Marlowe and Stroud 1956).
_FAR = (5.0 - np.sqrt(5.0)) / 20.0
_NEAR = 1.0 - 3.0 * _FAR
_FOUR_POINTS = np.full((4, 4), _FAR) + np.eye(4) * (_NEAR - _FAR)


@dataclass(frozen=True)
class Discretisation:
    """A mesh with nodes and quadrature.

    Attributes:
        element: which element.
        rest_nodes: node positions at rest [m], shape (N, 3); mesh vertices come first.
        layout: the same wherever the body is placed [m], shape (N, 3); see `TetMesh`.
        nodes: node indices of each tetrahedron, shape (T, n), n = 4 or 10.
        gradients: shape gradients at rest [1/m], shape (T, q, n, 3).
        weights: volume of each quadrature point [m^3], shape (T, q).
        load_fractions: integral of each shape function [m^3], shape (T, n).
        node_parents: the two vertices whose mean each node is at rest, shape (N, 2).
        surface_triangles: outward triangles between nodes, shape (F, 3).
    """

    element: Element
    rest_nodes: FloatArray
    layout: FloatArray
    nodes: IntArray
    gradients: FloatArray
    weights: FloatArray
    load_fractions: FloatArray
    node_parents: IntArray
    surface_triangles: IntArray

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return len(self.rest_nodes)


def corner_gradients(mesh: TetMesh) -> FloatArray:
    """Gradients of the four linear shape functions [1/m], shape (T, 4, 3)."""
    corners = mesh.rest_positions[mesh.tets]
    inverse = np.linalg.inv(corners[:, 1:] - corners[:, :1])
    gradients = np.empty((mesh.tet_count, 4, 3))
    gradients[:, 1:] = inverse.transpose(0, 2, 1)
    gradients[:, 0] = -gradients[:, 1:].sum(axis=1)
    return gradients


def rest_laplacian(discretisation: Discretisation) -> csc_matrix:
    """Return the stiffness of Poisson's equation on the body at rest [m], shape (N, N)."""
    gradients, nodes = discretisation.gradients, discretisation.nodes
    blocks = np.einsum('tq,tqai,tqbi->tab', discretisation.weights, gradients, gradients)
    count = nodes.shape[1]
    rows, columns = np.repeat(nodes, count, axis=1), np.tile(nodes, (1, count))
    shape = (discretisation.node_count, discretisation.node_count)
    return csc_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


def discretise(mesh: TetMesh, element: Element) -> Discretisation:
    """Put nodes and quadrature points on a mesh."""
    if element is Element.LINEAR:
        return _linear(mesh)
    return _quadratic(mesh)


def reshaped(known: Discretisation, mesh: TetMesh) -> Discretisation:
    """Discretise a mesh that differs in its positions only from one that was discretised."""
    integrals = _linear_integrals if known.element is Element.LINEAR else _quadratic_integrals
    gradients, weights, load_fractions = integrals(mesh)
    return replace(
        known,
        rest_nodes=mesh.rest_positions[known.node_parents].mean(axis=1),
        gradients=gradients,
        weights=weights,
        load_fractions=load_fractions,
    )


def _linear(mesh: TetMesh) -> Discretisation:
    own = np.arange(mesh.vertex_count, dtype=np.int32)
    gradients, weights, load_fractions = _linear_integrals(mesh)
    return Discretisation(
        element=Element.LINEAR,
        rest_nodes=mesh.rest_positions,
        layout=mesh.layout,
        nodes=mesh.tets,
        gradients=gradients,
        weights=weights,
        load_fractions=load_fractions,
        node_parents=np.stack([own, own], axis=1),
        surface_triangles=mesh.surface_triangles,
    )


def _linear_integrals(mesh: TetMesh) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return gradients, weights and load shares, see `Discretisation`."""
    volumes = mesh.volumes[:, None]
    return corner_gradients(mesh)[:, None], volumes, np.repeat(volumes / 4.0, 4, axis=1)


def _quadratic(mesh: TetMesh) -> Discretisation:
    edges, sides = mesh.edges
    own = np.arange(mesh.vertex_count, dtype=np.int32)
    gradients, weights, load_fractions = _quadratic_integrals(mesh)
    return Discretisation(
        element=Element.QUADRATIC,
        rest_nodes=np.vstack([mesh.rest_positions, mesh.rest_positions[edges].mean(axis=1)]),
        layout=np.vstack([mesh.layout, mesh.layout[edges].mean(axis=1)]),
        nodes=np.hstack([mesh.tets, sides + mesh.vertex_count]).astype(np.int32),
        gradients=gradients,
        weights=weights,
        load_fractions=load_fractions,
        node_parents=np.vstack([np.stack([own, own], axis=1), edges]).astype(np.int32),
        surface_triangles=_quadratic_surface(mesh),
    )


def _quadratic_integrals(mesh: TetMesh) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return gradients, weights and load shares, see `Discretisation`."""
    corner = corner_gradients(mesh)
    gradients = np.empty((mesh.tet_count, 4, 10, 3))
    for point, coordinates in enumerate(_FOUR_POINTS):
        gradients[:, point, :4] = (4.0 * coordinates[:, None] - 1.0) * corner
        for side, (i, j) in enumerate(TET_EDGES):
            gradients[:, point, 4 + side] = 4.0 * (
                coordinates[i] * corner[:, j] + coordinates[j] * corner[:, i]
            )
    volumes = mesh.volumes[:, None]
    # Integrals of the quadratic shape functions: -V/20 at corners, V/5 at mid-edges.
    load_fractions = np.hstack(
        [np.repeat(-volumes / 20.0, 4, axis=1), np.repeat(volumes / 5.0, 6, axis=1)]
    )
    return gradients, np.repeat(volumes / 4.0, 4, axis=1), load_fractions


def _quadratic_surface(mesh: TetMesh) -> IntArray:
    """Cut each face into four triangles through its mid-edge nodes."""
    edges, _ = mesh.edges
    keys = edges[:, 0].astype(np.int64) * mesh.vertex_count + edges[:, 1]
    a, b, c = mesh.surface_triangles.T.astype(np.int64)

    def middle(first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.int64]:
        low, high = np.minimum(first, second), np.maximum(first, second)
        found: NDArray[np.int64] = np.searchsorted(keys, low * mesh.vertex_count + high)
        return found + mesh.vertex_count

    ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
    quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    triangles = np.stack([np.stack(quarter, axis=1) for quarter in quarters], axis=1)
    return np.ascontiguousarray(triangles.reshape(-1, 3), dtype=np.int32)
