# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body of the examples: a straight beam of silicone, held at one end."""

from itertools import permutations
from pathlib import Path
from typing import Any

from diffcal_ros import PinholeCamera, StaticBody, TetMesh
from diffcal_ros.rigid_transform import apply, looking_at
import numpy as np
from numpy.typing import NDArray
import yaml

FloatArray = NDArray[np.float64]

SIZE = (0.12, 0.024, 0.018)  # [m]
GRAVITY = np.array([0.0, -9.81, 0.0])
CAMERA = PinholeCamera(320, 240, fx=350.0, fy=365.0, cx=150.5, cy=128.25)
# From the side and a little from above, a quarter of a metre away.
DEPTH_FROM_WORLD = looking_at(
    np.array([0.06, 0.0, 0.009]), np.array([0.025, 0.06, 0.25]), np.array([0.0, 1.0, 0.0])
)


def beam_mesh(cells: tuple[int, int, int] = (8, 2, 2)) -> TetMesh:
    """Cut the beam into cells and each of them into six tetrahedra.

    Args:
        cells: along x, y and z.

    Returns:
        A mesh with a corner at the origin [m].
    """
    axes = [np.linspace(0.0, size, count + 1) for size, count in zip(SIZE, cells, strict=True)]
    positions = np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1).reshape(-1, 3)
    strides = np.array([(cells[1] + 1) * (cells[2] + 1), cells[2] + 1, 1])
    first = np.stack(np.meshgrid(*map(np.arange, cells), indexing='ij'), axis=-1).reshape(-1, 3)
    tets = []
    for order in permutations(range(3)):
        # From the lowest corner of a cell along one axis after the other to the highest.
        path = np.cumsum([0, *strides[list(order)]])
        if np.linalg.det(np.eye(3)[list(order)]) < 0.0:
            path[[1, 2]] = path[[2, 1]]
        tets.append((first @ strides)[:, None] + path)
    return TetMesh(positions, np.concatenate(tets).astype(np.int32))


def held_end(mesh: TetMesh) -> NDArray[np.int32]:
    """Return the vertices in the clamp, at the end where x is 0."""
    return np.flatnonzero(mesh.rest_positions[:, 0] == 0.0).astype(np.int32)


def points_in_camera(body: StaticBody) -> FloatArray:
    """Return the nodes of a body that has settled, in the depth camera's frame [m]."""
    return apply(DEPTH_FROM_WORLD, body.state.positions)


def write_scene(folder: Path, youngs_modulus: float, **more: Any) -> Path:
    """Write the beam and its scene into a folder.

    Args:
        folder: to write to.
        youngs_modulus: where a fit starts [Pa].
        more: sections of the scene beside those below, or in their place.
    """
    mesh = beam_mesh()
    lines = [f'v {x} {y} {z}' for x, y, z in mesh.rest_positions.tolist()]
    lines += [f't {a} {b} {c} {d}' for a, b, c, d in mesh.tets.tolist()]
    (folder / 'beam.tet').write_text('\n'.join(lines) + '\n')
    material = {'youngs_modulus': youngs_modulus, 'poissons_ratio': 0.45, 'density': 1080.0}
    scene = {
        'format': 1,
        'name': 'beam',
        'mesh': {'file': 'beam.tet', 'unit': 'm', 'element': 'quadratic'},
        'held': {'clamp': {'box': {'x': [-float('inf'), 0.0]}}},
        'regions': {'silicone': material},
        'gravity': GRAVITY.tolist(),
        'placement': {'translation': [0.0, 0.0, 0.0]},
        'pose': {'source': 'stored', 'position_std': 0.0, 'rotation_std_deg': 0.0},
        'stored_depth_from_world': {
            'rotation_matrix': DEPTH_FROM_WORLD[:3, :3].tolist(),
            'translation': DEPTH_FROM_WORLD[:3, 3].tolist(),
        },
        'camera': {
            name: getattr(CAMERA, name) for name in ('width', 'height', 'fx', 'fy', 'cx', 'cy')
        },
        'fit': ['youngs_modulus'],
        **more,
    }
    path = folder / 'scene.yaml'
    path.write_text(yaml.safe_dump(scene, sort_keys=False))
    return path
