# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Small bodies for tests."""

from diffcal_ros.tet_mesh import TetMesh
import numpy as np

# Six tetrahedra of a cube, all of positive volume (Kuhn).
_CUBE_TETS = [
    (0, 1, 3, 7),
    (0, 3, 2, 7),
    (0, 2, 6, 7),
    (0, 6, 4, 7),
    (0, 4, 5, 7),
    (0, 5, 1, 7),
]


def beam_mesh(
    counts: tuple[int, int, int] = (6, 2, 2),
    size: tuple[float, float, float] = (0.12, 0.03, 0.02),
) -> TetMesh:
    """Cut a box [m] with its corner at the origin into tetrahedra."""
    nx, ny, nz = counts
    axes = [np.linspace(0.0, s, n + 1) for n, s in zip(counts, size, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1).reshape(-1, 3)

    def number(i: int, j: int, k: int) -> int:
        return (i * (ny + 1) + j) * (nz + 1) + k

    tets = []
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                corners = [
                    number(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)) for c in range(8)
                ]
                tets.extend([[corners[c] for c in tet] for tet in _CUBE_TETS])
    mesh = TetMesh(grid, np.array(tets, dtype=np.int32))
    turned = mesh.volumes < 0.0
    tets_array = mesh.tets.copy()
    tets_array[turned, 2], tets_array[turned, 3] = mesh.tets[turned, 3], mesh.tets[turned, 2]
    return TetMesh(grid, tets_array)


def held_end(mesh: TetMesh, length: float = 1e-6) -> np.ndarray:
    """Vertices at the low-x end of a body."""
    low = mesh.rest_positions[:, 0].min()
    return np.flatnonzero(mesh.rest_positions[:, 0] <= low + length).astype(np.int32)
