# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make the bundled sample: a soft ribbed finger of our own design, simulated and recorded.

    python bags/make_sample.py [OUT]

OUT (default: bags/sample) gets the mesh, the scene and a short recording. Everything follows from
the numbers below and the seed; with the versions of constraints.txt the files are the same byte
for byte. Other versions may compress them otherwise, or round a depth to the next step in a few
pixels.
"""

from itertools import permutations
from pathlib import Path
import sys
import tempfile

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.recorder import record, RecorderSettings
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray
import yaml

FloatArray = NDArray[np.float64]

# The finger, in millimetres: a strip along x with ribs under it, thinner towards the tip at x = 0.
_HELD = 30.0
_RIB, _SLOT, _RIB_COUNT = 10.0, 6.0, 8
_STRIP, _RIB_DEPTH, _WIDTH = 12.0, 12.0, 28.0
_TIP_WIDTH, _TIP_DEPTH = 0.65, 0.6  # Shares of those at the clamp.
_STRIP_CELLS, _RIB_CELLS, _WIDTH_CELLS = 2, 2, 3
_HELD_CELLS = 3

_YOUNGS_MODULUS = 240e3  # [Pa]
_START_FACTOR = 1.4
_HEADER = """\
# yaml-language-server: $schema=../../config/scene.schema.json
# The bundled sample, made by bags/make_sample.py: synthetic, no camera took it.
"""
# Colour images small enough to bundle; what lies beyond the clamp is cut off, like in the public
# captures.
_COLOR_CAMERA = PinholeCamera(640, 360, fx=451.5, fy=451.0, cx=322.5, cy=178.75)
_SETTINGS = RecorderSettings(
    timing=Timing(frames=12, rate=10.0),
    color_frames=4,
    seed=20240229,
    is_refined=True,
    start_factor=1.4,
    color_camera=_COLOR_CAMERA,
    lidar=LidarModel(farthest=0.45),
)


def finger() -> TetMesh:
    """Mesh the finger: cells on a grid, each cut into six tetrahedra, then tapered."""
    # Ribs and slots take two cells each.
    free = np.repeat([_RIB, *[_SLOT, _RIB] * (_RIB_COUNT - 1)], 2) / 2.0
    lengths = [*free, *[_HELD / _HELD_CELLS] * _HELD_CELLS]
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    upright = np.concatenate(
        [
            np.linspace(-_RIB_DEPTH, 0.0, _RIB_CELLS, endpoint=False),
            np.linspace(0.0, _STRIP, _STRIP_CELLS + 1),
        ]
    )
    across = np.linspace(-0.5 * _WIDTH, 0.5 * _WIDTH, _WIDTH_CELLS + 1)
    cells = np.ones((len(along) - 1, len(upright) - 1, len(across) - 1), dtype=bool)
    for slot in range(_RIB_COUNT - 1):
        cells[4 * slot + 2 : 4 * slot + 4, :_RIB_CELLS] = False
    mesh = _tets(np.meshgrid(along, upright, across, indexing='ij'), cells)
    return TetMesh(1e-3 * _tapered(mesh.rest_positions), mesh.tets)


def _tets(grid: list[FloatArray], cells: NDArray[np.bool_]) -> TetMesh:
    """Cut the cells that are there into six tetrahedra each."""
    positions = np.stack(grid, axis=-1).reshape(-1, 3)
    rows, columns = grid[0].shape[1:]
    steps = np.array([rows * columns, columns, 1])
    lows = np.argwhere(cells) @ steps
    # Each order of the three axes is a path along a cell's edges from corner to far corner.
    paths = [np.cumsum([0, *steps[list(order)]]) for order in permutations(range(3))]
    tets = np.concatenate([lows[:, None] + path for path in paths])
    corners = positions[tets]
    turned = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    tets[turned] = tets[turned][:, [0, 1, 3, 2]]
    used, renumbered = np.unique(tets, return_inverse=True)
    return TetMesh(positions[used], renumbered.reshape(-1, 4).astype(np.int32))


def _tapered(positions: FloatArray) -> FloatArray:
    free = positions[:, 0].max() - _HELD
    share = np.clip(positions[:, 0] / free, 0.0, 1.0)
    depth = _TIP_DEPTH + (1.0 - _TIP_DEPTH) * share
    width = _TIP_WIDTH + (1.0 - _TIP_WIDTH) * share
    # The upper side stays level.
    lowered = _STRIP - depth * (_STRIP - positions[:, 1])
    return np.stack([positions[:, 0], lowered, width * positions[:, 2]], axis=1)


def vtk_text(mesh: TetMesh) -> str:
    """Write a mesh in millimetres as a legacy VTK file."""
    points = [f'{x:.6g} {y:.6g} {z:.6g}' for x, y, z in (1e3 * mesh.rest_positions).tolist()]
    tets = [f'4 {a} {b} {c} {d}' for a, b, c, d in mesh.tets.tolist()]
    return '\n'.join(
        [
            '# vtk DataFile Version 3.0',
            'soft ribbed finger [mm], made by bags/make_sample.py',
            'ASCII',
            'DATASET UNSTRUCTURED_GRID',
            f'POINTS {len(points)} double',
            *points,
            f'CELLS {len(tets)} {5 * len(tets)}',
            *tets,
            f'CELL_TYPES {len(tets)}',
            *['10'] * len(tets),
            '',
        ]
    )


def scene_document(mesh: TetMesh) -> dict[str, object]:
    """Describe the rig; its start values are the truth."""
    clamp = float(mesh.extent[1, 0])
    return {
        'format': 1,
        'name': 'soft finger (synthetic sample)',
        'mesh': {'file': 'finger.vtk', 'unit': 'mm', 'element': 'quadratic'},
        # The marker sticks on the clamp's block; the finger points to its left.
        'placement': {'translation': [0.015 - clamp, -0.045, -0.040]},
        'held': {'clamp': {'box': {'x': [clamp - 1e-3 * _HELD, float('inf')]}}},
        'regions': {
            'silicone': {
                'youngs_modulus': {'start': _YOUNGS_MODULUS, 'min': 5.0e3, 'max': 5.0e6},
                'poissons_ratio': 0.49,
                'density': 1080.0,
            }
        },
        'gravity': [0.0, -9.81, 0.0],
        'marker': {'dictionary': 'DICT_6X6_250', 'id': 0, 'side': 0.025},
        'camera': 'from_camera_info',
        'color_camera': 'from_camera_info',
        'fit': ['youngs_modulus', 'rigid_offset'],
    }


def make_sample(out: Path) -> None:
    """Write the sample to a folder; a sample that is there is replaced."""
    mesh = finger()
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / 'rig.yaml'
        (source.parent / 'finger.vtk').write_text(vtk_text(mesh))
        source.write_text(yaml.safe_dump(scene_document(mesh), sort_keys=False))
        made = record(load_scene(source), out, _SETTINGS, overwrite=True)
    write_text_atomically(made.scene, _HEADER + made.scene.read_text())


if __name__ == '__main__':
    make_sample(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / 'sample')
