# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two meshes of one body: tetrahedra for the fit, other and smaller hexahedra for the truth."""

from itertools import permutations

from diffcal_ros.tet_mesh import TetMesh
import numpy as np

from benchmarks.blind.hexahedra import CORNERS, HexMesh
from benchmarks.zoo.solids import Counts, cut, IntArray, Solid

_FINER = 1.5  # Truth's cells along an edge of the fit's, rounded up.
_AT_CLAMP = 1e-9  # [m]


def fit_mesh(solid: Solid, fineness: float = 1.0) -> TetMesh:
    """Cut a body into six tetrahedra a cell, mirrored from cell to cell.

    Args:
        solid: the body.
        fineness: cells along an edge over the body's own number.
    """
    grid = cut(solid, _counted(solid, lambda count: max(1, round(fineness * count))))
    paths = [[np.zeros(3, dtype=np.int64)] for _ in range(6)]
    for path, order in zip(paths, permutations(range(3)), strict=True):
        for axis in order:
            path.append(path[-1] + np.eye(3, dtype=np.int64)[axis])
    local = np.array(paths)
    odd = (grid.cells % 2 == 1)[:, None, None]
    triples = grid.cells[:, None, None] + np.where(odd, 1 - local[None], local[None])
    points, tets = grid.numbered(triples.reshape(-1, 4, 3), 1)
    edges = points[tets[:, 1:]] - points[tets[:, :1]]
    is_inverted = np.linalg.det(edges) < 0.0
    tets[is_inverted] = tets[is_inverted][:, [0, 1, 3, 2]]
    return TetMesh(points, tets.astype(np.int32))


def held_vertices(solid: Solid, mesh: TetMesh) -> IntArray:
    """Return the vertices of a mesh in the clamp, shape (h,)."""
    return np.flatnonzero(mesh.rest_positions[:, 0] <= solid.clamp + _AT_CLAMP).astype(np.int32)


def true_mesh(solid: Solid, fineness: float = 1.0) -> HexMesh:
    """Cut a body into 20-node hexahedra.

    Args:
        solid: the body.
        fineness: cells along an edge over a truth's own number.
    """
    grid = cut(solid, _counted(solid, lambda count: round(fineness * np.ceil(_FINER * count))))
    local = (CORNERS + 1.0).astype(np.int64)
    nodes, cells = grid.numbered(2 * grid.cells[:, None] + local[None], 2)
    held = np.flatnonzero(nodes[:, 0] <= solid.clamp + _AT_CLAMP)
    return HexMesh(nodes, nodes, cells, grid.outer_faces(), held)


def _counted(solid: Solid, count) -> Counts:
    along, across, up = (tuple(count(own) for own in axis) for axis in solid.cells)
    return along, across, up
