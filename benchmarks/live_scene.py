# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body that the live benchmark looks at: a cantilever of 1,800 tetrahedra."""

from itertools import permutations
from pathlib import Path
from typing import Any

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import yaml

MODULUS = 120e3  # [Pa]
_CELLS = (15, 5, 4)
_SIZE = (0.16, 0.030, 0.024)  # [m]
_HELD = 0.025  # [m]


def cantilever(cells: tuple[int, int, int] = _CELLS) -> TetMesh:
    """Mesh a box: cells on a grid, each cut into six tetrahedra."""
    axes = [np.linspace(0.0, size, n + 1) for size, n in zip(_SIZE, cells, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1)
    numbers = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    lows = numbers[:-1, :-1, :-1].ravel()
    steps = np.array([numbers[1, 0, 0], numbers[0, 1, 0], numbers[0, 0, 1]])
    # Each order of the three axes is a path along a cell's edges from corner to far corner.
    paths = [np.cumsum([0, *steps[list(order)]]) for order in permutations(range(3))]
    tets = np.concatenate([lows[:, None] + path for path in paths])
    corners = grid.reshape(-1, 3)[tets]
    turned = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    tets[turned] = tets[turned][:, [0, 1, 3, 2]]
    return TetMesh(grid.reshape(-1, 3), tets.astype(np.int32))


def write_scene(
    folder: Path,
    element: Element,
    cells: tuple[int, int, int] = _CELLS,
    motion: dict[str, Any] | None = None,
) -> Path:
    """Write mesh and scene; the start values are the truth.

    Args:
        folder: to make.
        element: on the mesh.
        cells: of the mesh along each axis.
        motion: `held`, `region`, `motion` and `fit` of a body that moves.
    """
    mesh = cantilever(cells)
    folder.mkdir(parents=True)
    lines = [f'v {x:.9g} {y:.9g} {z:.9g}' for x, y, z in mesh.rest_positions.tolist()]
    lines += [f't {a} {b} {c} {d}' for a, b, c, d in mesh.tets.tolist()]
    (folder / 'cantilever.tet').write_text('\n'.join(lines) + '\n')
    document: dict[str, Any] = {
        'format': 1,
        'name': 'cantilever',
        'mesh': {'file': 'cantilever.tet', 'unit': 'm', 'element': element.value},
        'held': {'clamp': {'box': {'x': [_SIZE[0] - _HELD, float('inf')]}}},
        'regions': {
            'body': {'youngs_modulus': MODULUS, 'poissons_ratio': 0.45, 'density': 1080.0}
        },
        'placement': {'translation': [0.0, 0.0, 0.0]},
        'gravity': [0.0, -9.81, 0.0],
        'fit': ['youngs_modulus', 'rigid_offset'],
    }
    if motion is not None:
        document['held'].update(motion['held'])
        document['regions']['body'].update(motion['region'])
        document.update(motion=motion['motion'], fit=motion['fit'])
    path = folder / 'scene.yaml'
    path.write_text(yaml.safe_dump(document, sort_keys=False))
    return path
