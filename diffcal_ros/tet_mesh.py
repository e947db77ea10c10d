# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A tetrahedral mesh: positions at rest, tetrahedra, and what follows from them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Corner pairs of the six edges; the order of mid-edge nodes throughout (VTK's order).
TET_EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
# Faces with outward normals for a tetrahedron of positive volume.
TET_FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])

# A body outside these sizes is almost always a wrong unit: 5 mm to 5 m.
_SMALLEST_BODY = 0.005
_LARGEST_BODY = 5.0
_EQUAL = 1.0 + 1e-6  # Lengths whose ratio is less are equal.
# Volume over the cube of the mean edge; 0.1179 for a regular tetrahedron.
_DEGENERATE_QUALITY = 1e-4


@dataclass(frozen=True)
class TetMesh:
    """A body cut into tetrahedra.

    Attributes:
        rest_positions: [m], shape (V, 3), in the object's own frame.
        tets: vertex indices, shape (T, 4), positive volume.
        as_given: positions before the body was placed [m], shape (V, 3); None: it was not.
    """

    rest_positions: FloatArray
    tets: IntArray
    as_given: FloatArray | None = None

    def placed(self, rest_positions: FloatArray) -> 'TetMesh':
        """Return the same body elsewhere, which knows that it is the same.

        Args:
            rest_positions: [m], shape (V, 3).
        """
        return TetMesh(rest_positions, self.tets, self.layout)

    @property
    def layout(self) -> FloatArray:
        """Positions that are the same wherever the body is placed [m], shape (V, 3)."""
        return self.rest_positions if self.as_given is None else self.as_given

    @property
    def vertex_count(self) -> int:
        """Number of vertices."""
        return len(self.rest_positions)

    @property
    def tet_count(self) -> int:
        """Number of tetrahedra."""
        return len(self.tets)

    @cached_property
    def volumes(self) -> FloatArray:
        """Signed rest volumes [m^3], shape (T,)."""
        corners = self.rest_positions[self.tets]
        return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0

    @cached_property
    def centroids(self) -> FloatArray:
        """Centres of the tetrahedra at rest [m], shape (T, 3)."""
        return self.rest_positions[self.tets].mean(axis=1)

    @cached_property
    def surface_triangles(self) -> IntArray:
        """Faces of one tetrahedron only, outward normals, shape (F, 3)."""
        faces = self.tets[:, TET_FACES].reshape(-1, 3)
        return np.ascontiguousarray(faces[self._outer_faces], dtype=np.int32)

    @cached_property
    def surface_tets(self) -> IntArray:
        """The tetrahedron of each surface triangle, shape (F,)."""
        return (self._outer_faces // len(TET_FACES)).astype(np.int32)

    @cached_property
    def _outer_faces(self) -> NDArray[np.int64]:
        """Numbers of the faces of one tetrahedron only, four a tetrahedron, ascending."""
        faces = np.sort(self.tets[:, TET_FACES].reshape(-1, 3), axis=1)
        _, first, count = np.unique(faces, axis=0, return_index=True, return_counts=True)
        return np.sort(first[count == 1])

    @cached_property
    def edges(self) -> tuple[IntArray, IntArray]:
        """Unique edges, shape (E, 2), and the edge of each tetrahedron's side, shape (T, 6)."""
        sides = np.sort(self.tets[:, TET_EDGES].reshape(-1, 2), axis=1)
        unique, index = np.unique(sides, axis=0, return_inverse=True)
        return unique.astype(np.int32), index.reshape(-1, 6).astype(np.int32)

    @cached_property
    def extent(self) -> FloatArray:
        """Lower and upper corner of the bounding box [m], shape (2, 3)."""
        return np.stack([self.rest_positions.min(axis=0), self.rest_positions.max(axis=0)])

    def refined(self) -> tuple['TetMesh', IntArray]:
        """Cut every tetrahedron into eight (half the mesh size).

        The inner octahedron is cut along its shortest diagonal, which keeps the shapes from
        getting flatter with every level.

        Returns:
            The finer mesh, whose first V vertices are the old ones and whose next E are the
            edge midpoints, and the parent of each new tetrahedron, shape (8 T,).
        """
        edges, sides = self.edges
        positions = np.vstack([self.rest_positions, self.rest_positions[edges].mean(axis=1)])
        mid = sides + self.vertex_count
        m01, m12, m02, m03, m13, m23 = mid.T
        c0, c1, c2, c3 = self.tets.T
        corner_tets = [
            (c0, m01, m02, m03),
            (m01, c1, m12, m13),
            (m02, m12, c2, m23),
            (m03, m13, m23, c3),
        ]
        diagonals = [(m01, m23), (m12, m03), (m02, m13)]
        # The ring of the other four midpoints around each diagonal.
        rings = [(m02, m03, m13, m12), (m01, m02, m23, m13), (m01, m03, m23, m12)]
        lengths = np.stack(
            [np.linalg.norm(positions[a] - positions[b], axis=1) for a, b in diagonals]
        )
        # Of equal ones the first: rounding, and so the frame, must not choose.
        shortest = (lengths < _EQUAL * lengths.min(axis=0)).argmax(axis=0)
        inner = []
        for k in range(4):
            candidates = np.stack(
                [
                    np.stack([a, b, ring[k], ring[(k + 1) % 4]], axis=-1)
                    for (a, b), ring in zip(diagonals, rings, strict=True)
                ]
            )
            inner.append(candidates[shortest, np.arange(self.tet_count)])
        tets = np.concatenate([np.stack(tet, axis=-1) for tet in corner_tets] + inner)
        tets = _oriented(positions, tets)
        parents = np.tile(np.arange(self.tet_count, dtype=np.int32), 8)
        return TetMesh(positions, tets.astype(np.int32)), parents


def _oriented(positions: FloatArray, tets: NDArray[np.integer]) -> NDArray[np.integer]:
    """Swap two corners of each tetrahedron of negative volume."""
    corners = positions[tets]
    turned = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    tets = tets.copy()
    tets[turned, 2], tets[turned, 3] = tets[turned, 3], tets[turned, 2].copy()
    return tets


def mesh_problems(mesh: TetMesh) -> list[str]:
    """List what is wrong with a mesh, each with what to do; empty when it is sound."""
    if mesh.tet_count == 0:
        return ['the mesh has no tetrahedra: give a volume mesh, or a watertight surface']
    if not np.isfinite(mesh.rest_positions).all():
        return ['vertex positions hold NaN or Inf: export the mesh again']
    if mesh.tets.min() < 0 or mesh.tets.max() >= mesh.vertex_count:
        outside = (mesh.tets < 0) | (mesh.tets >= mesh.vertex_count)
        return [
            f'tetrahedra name vertex {mesh.tets[outside][0]}, but there are only 0 to '
            f'{mesh.vertex_count - 1}: indices must be 0-based and within the vertex list'
        ]
    return [*_tet_problems(mesh), *_size_problems(mesh)]


def _tet_problems(mesh: TetMesh) -> list[str]:
    problems = []
    corners = mesh.rest_positions[mesh.tets]
    edge_length = np.linalg.norm(
        corners[:, TET_EDGES[:, 0]] - corners[:, TET_EDGES[:, 1]], axis=-1
    ).mean(axis=1)
    quality = mesh.volumes / np.maximum(edge_length, 1e-30) ** 3
    flat = np.abs(quality) < _DEGENERATE_QUALITY
    inverted = (quality < 0.0) & ~flat
    if inverted.any():
        problems.append(
            f'{inverted.sum()} of {mesh.tet_count} tetrahedra are inverted (negative volume, '
            f'first: {np.flatnonzero(inverted)[0]}): swap two of their corners'
        )
    if flat.any():
        problems.append(
            f'{flat.sum()} of {mesh.tet_count} tetrahedra are degenerate (no volume, '
            f'first: {np.flatnonzero(flat)[0]}): mesh the body again with a quality bound'
        )
    distinct = len(np.unique(np.sort(mesh.tets, axis=1), axis=0))
    if distinct < mesh.tet_count:
        problems.append(
            f'{mesh.tet_count - distinct} tetrahedra are duplicates: remove the copies'
        )
    unused = mesh.vertex_count - len(np.unique(mesh.tets))
    if unused:
        problems.append(f'{unused} vertices belong to no tetrahedron (unreferenced): remove them')
    return problems


def _size_problems(mesh: TetMesh) -> list[str]:
    size = float((mesh.extent[1] - mesh.extent[0]).max())
    if _SMALLEST_BODY <= size <= _LARGEST_BODY:
        return []
    return [
        f"the body is {size:.4g} m long: set the mesh's unit (m, cm or mm) in the scene; "
        f'bodies of {_SMALLEST_BODY:g} to {_LARGEST_BODY:g} m are taken'
    ]
