# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The tetrahedral mesh of the nominal body that is handed out, with region tags."""

from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.lattice import cut, cut_by_counts, Lattice, numbered
from benchmarks.blind.other_bodies import OtherShape
from benchmarks.blind.shapes import FloatArray, Shape

IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class TetMesh:
    """Tetrahedra of the nominal body.

    Attributes:
        points: object frame [m], shape (V, 3).
        tets: positively oriented, shape (T, 4).
        regions: 0 in the half at the clamp, 1 in the half at the tip, shape (T,).
    """

    points: FloatArray
    tets: IntArray
    regions: IntArray


def mesh_tetrahedra(shape: Shape, coarsening: float = 1.0) -> TetMesh:
    """Mesh a body: six tetrahedra a cell, mirrored from cell to cell so that faces match.

    Args:
        shape: the body.
        coarsening: how many times longer than usual the cells are.
    """
    lattice = _cells(shape, coarsening)
    paths = []
    for order in permutations(range(3)):
        corner = np.zeros(3, dtype=np.int64)
        path = [corner]
        for axis in order:
            corner = corner.copy()
            corner[axis] = 1
            path.append(corner)
        paths.append(path)
    local = np.array(paths)
    odd = (lattice.cells % 2 == 1)[:, None, None]
    mirrored = np.where(odd, 1 - local[None], local[None])
    triples = lattice.cells[:, None, None] + mirrored
    grid, tets = numbered(triples.reshape(-1, 4, 3), lattice.ticks)
    share = shape.arc_share(grid)[tets].mean(axis=1)
    points = shape.place(grid)
    edges = points[tets[:, 1:]] - points[tets[:, :1]]
    is_inverted = np.linalg.det(edges) < 0.0
    tets[is_inverted] = tets[is_inverted][:, [0, 1, 3, 2]]
    return TetMesh(points, tets, (share > 0.5).astype(np.int64))


def _cells(shape: Shape, coarsening: float) -> Lattice:
    if isinstance(shape, OtherShape):
        return cut_by_counts(shape, shape.tet_counts)
    width, height = shape.section
    size = (0.0057, min(width / 2.6, 0.0068), min(height / 1.8, 0.0068))
    if coarsening > 1.0:
        size = (0.0057 * coarsening, width / 1.6, height / 1.6)
    return cut(shape, size, held_cells=max(round(4 / coarsening), 1))


def write_vtk(mesh: TetMesh, path: Path) -> None:
    """Write a legacy ASCII file in millimetres with cell data `region`."""
    lines = ['# vtk DataFile Version 3.0', 'nominal body [mm]', 'ASCII']
    lines += ['DATASET UNSTRUCTURED_GRID', f'POINTS {len(mesh.points)} double']
    lines += [' '.join(f'{value:.9g}' for value in point) for point in 1e3 * mesh.points]
    lines.append(f'CELLS {len(mesh.tets)} {5 * len(mesh.tets)}')
    lines += [f'4 {a} {b} {c} {d}' for a, b, c, d in mesh.tets]
    lines.append(f'CELL_TYPES {len(mesh.tets)}')
    lines += ['10'] * len(mesh.tets)
    lines += [f'CELL_DATA {len(mesh.tets)}', 'SCALARS region int 1', 'LOOKUP_TABLE default']
    lines += [str(region) for region in mesh.regions]
    path.write_text('\n'.join(lines) + '\n')
