# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A small beam filmed by the synthetic recorder: everything a calibration reads, in a second."""

import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.recorder import record, RecorderSettings, SyntheticRecording
import yaml

from support.beams import beam_mesh

MODULUS = 90e3
DEPTH_CAMERA = PinholeCamera(400, 300, 290.0, 294.0, 203.5, 146.25)
COLOR_CAMERA = PinholeCamera(640, 360, 452.0, 449.0, 322.5, 178.75)
SETTINGS = RecorderSettings(
    timing=Timing(4), color_frames=2, depth_camera=DEPTH_CAMERA, color_camera=COLOR_CAMERA, seed=5
)
_DOCUMENT: dict[str, Any] = {
    'format': 1,
    'name': 'beam',
    'mesh': {'file': 'beam.tet', 'unit': 'mm'},
    'held': {'clamp': {'box': {'x': [0.1, float('inf')]}}},
    'regions': {'body': {'youngs_modulus': MODULUS, 'poissons_ratio': 0.45, 'density': 1080}},
    'gravity': [0, -9.81, 0],
    'placement': {'translation': [-0.115, -0.055, -0.035]},
    'marker': {'dictionary': 'DICT_6X6_250', 'id': 7, 'side': 0.03},
    'fit': ['youngs_modulus'],
}


def write_beam_scene(folder: Path, changes: dict[str, Any] | None = None) -> Path:
    """Write the scene whose start values are the truth; dotted keys change it, `...` removes."""
    mesh = beam_mesh((8, 2, 2), (0.12, 0.024, 0.02))
    lines = [f'v {x} {y} {z}' for x, y, z in (1e3 * mesh.rest_positions).tolist()]
    lines += [f't {a} {b} {c} {d}' for a, b, c, d in mesh.tets.tolist()]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / 'beam.tet').write_text('\n'.join(lines) + '\n')
    document = copy.deepcopy(_DOCUMENT)
    for dotted, value in copy.deepcopy(changes or {}).items():
        *sections, key = dotted.split('.')
        section = document
        for name in sections:
            section = section[name]
        if value is ...:
            del section[key]
        else:
            section[key] = value
    path = folder / 'true_scene.yaml'
    path.write_text(yaml.safe_dump(document, sort_keys=False))
    return path


def record_beam(
    folder: Path,
    changes: dict[str, Any] | None = None,
    *,
    frames: int | None = None,
    **settings: Any,
) -> SyntheticRecording:
    """Film the beam into `folder`/recorded."""
    if frames is not None:
        settings['timing'] = Timing(frames)
    scene = load_scene(write_beam_scene(folder, changes))
    return record(scene, folder / 'recorded', replace(SETTINGS, **settings))
