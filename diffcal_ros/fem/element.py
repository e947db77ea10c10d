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
        nodes: node indices of each tetrahedron, shape (T, n), n = 4 or 10.
        gradients: shape gradients at rest [1/m], shape (T, q, n, 3).
        weights: volume of each quadrature point [m^3], shape (T, q).
        load_shares: integral of each shape function [m^3], shape (T, n).
        node_parents: the two vertices whose mean each node is at rest, shape (N, 2).
        surface_triangles: outward triangles between nodes, shape (F, 3).
    """

    element: Element
    rest_nodes: FloatArray
    nodes: IntArray
    gradients: FloatArray
    weights: FloatArray
    load_shares: FloatArray
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


def discretise(mesh: TetMesh, element: Element) -> Discretisation:
    """Put nodes and quadrature points on a mesh."""
    if element is Element.LINEAR:
        return _linear(mesh)
    return _quadratic(mesh)


def reshaped(known: Discretisation, mesh: TetMesh) -> Discretisation:
    """Discretise a mesh that differs in its positions only from one that was discretised."""
    corner = corner_gradients(mesh)
    is_linear = known.element is Element.LINEAR
    return replace(
        known,
        rest_nodes=mesh.rest_positions[known.node_parents].mean(axis=1),
        gradients=corner[:, None] if is_linear else _quadratic_gradients(corner),
        weights=_linear_weights(mesh) if is_linear else _quadratic_weights(mesh),
        load_shares=_linear_shares(mesh) if is_linear else _quadratic_shares(mesh),
    )


def _linear(mesh: TetMesh) -> Discretisation:
    own = np.arange(mesh.vertex_count, dtype=np.int32)
    return Discretisation(
        element=Element.LINEAR,
        rest_nodes=mesh.rest_positions,
        nodes=mesh.tets,
        gradients=corner_gradients(mesh)[:, None],
        weights=_linear_weights(mesh),
        load_shares=_linear_shares(mesh),
        node_parents=np.stack([own, own], axis=1),
        surface_triangles=mesh.surface_triangles,
    )


def _linear_weights(mesh: TetMesh) -> FloatArray:
    return mesh.volumes[:, None]


def _linear_shares(mesh: TetMesh) -> FloatArray:
    return np.repeat(mesh.volumes[:, None] / 4.0, 4, axis=1)


def _quadratic(mesh: TetMesh) -> Discretisation:
    edges, sides = mesh.edges
    own = np.arange(mesh.vertex_count, dtype=np.int32)
    return Discretisation(
        element=Element.QUADRATIC,
        rest_nodes=np.vstack([mesh.rest_positions, mesh.rest_positions[edges].mean(axis=1)]),
        nodes=np.hstack([mesh.tets, sides + mesh.vertex_count]).astype(np.int32),
        gradients=_quadratic_gradients(corner_gradients(mesh)),
        weights=_quadratic_weights(mesh),
        load_shares=_quadratic_shares(mesh),
        node_parents=np.vstack([np.stack([own, own], axis=1), edges]).astype(np.int32),
        surface_triangles=_quadratic_surface(mesh),
    )


def _quadratic_gradients(corner: FloatArray) -> FloatArray:
    """Return gradients of the ten shape functions at four points [1/m], shape (T, 4, 10, 3)."""
    gradients = np.empty((len(corner), 4, 10, 3))
    for point, coordinates in enumerate(_FOUR_POINTS):
        gradients[:, point, :4] = (4.0 * coordinates[:, None] - 1.0) * corner
        for side, (i, j) in enumerate(TET_EDGES):
            gradients[:, point, 4 + side] = 4.0 * (
                coordinates[i] * corner[:, j] + coordinates[j] * corner[:, i]
            )
    return gradients


def _quadratic_weights(mesh: TetMesh) -> FloatArray:
    return np.repeat(mesh.volumes[:, None] / 4.0, 4, axis=1)


def _quadratic_shares(mesh: TetMesh) -> FloatArray:
    """Return integrals of the shape functions: -V/20 at corners, V/5 at mid-edges."""
    volumes = mesh.volumes[:, None]
    return np.hstack([np.repeat(-volumes / 20.0, 4, axis=1), np.repeat(volumes / 5.0, 6, axis=1)])


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
