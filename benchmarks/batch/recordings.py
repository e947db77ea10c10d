# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hundreds of small recordings of beams, of three materials, a few of them of none."""

import csv
from dataclasses import replace
import json
from pathlib import Path

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Quantity
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.recorder import record, RecorderSettings
import numpy as np
import yaml

MANIFEST, TRUTH = 'batch.csv', 'truth.json'
OPTIONS = '--no-search --no-mesh-error'
# Moduli of the materials [Pa], and how bodies of one differ, as a share.
MATERIALS = {'soft': 60e3, 'middle': 90e3, 'hard': 140e3}
SPREAD = 0.05
# Every fiftieth body was mixed up, and is so much harder than its material.
MIXED_UP_EVERY, MIXED_UP = 50, 1.7

_SIZE, _COUNTS = (0.12, 0.024, 0.02), (6, 2, 2)
_SETTINGS = RecorderSettings(
    timing=Timing(2),
    color_frames=1,
    depth_camera=PinholeCamera(240, 180, 174.0, 176.4, 122.1, 87.75),
    color_camera=PinholeCamera(640, 360, 452.0, 449.0, 322.5, 178.75),
    start_factor=1.2,
)
_SCENE = {
    'format': 1,
    'name': 'beam',
    'mesh': {'file': 'beam.tet', 'unit': 'mm'},
    'held': {'clamp': {'box': {'x': [0.1, float('inf')]}}},
    'regions': {'body': {'youngs_modulus': 90e3, 'poissons_ratio': 0.45, 'density': 1080}},
    'gravity': [0, -9.81, 0],
    'placement': {'translation': [-0.115, -0.055, -0.035]},
    'marker': {'dictionary': 'DICT_6X6_250', 'id': 7, 'side': 0.03},
    'fit': ['youngs_modulus'],
}


def make_recordings(folder: Path, count: int, seed: int) -> Path:
    """Film bodies that are not there yet; return the manifest of all.

    Every body has noise, steps and a modulus of its own; what is true goes to truth.json, which no
    fit reads.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_mesh(folder / 'beam.tet')
    path = folder / 'true_scene.yaml'
    path.write_text(yaml.safe_dump(_SCENE, sort_keys=False))
    scene, names = load_scene(path), list(MATERIALS)
    truth, rows = {}, []
    for number in range(count):
        name, material = f'body_{number:03}', names[number % len(names)]
        random = np.random.default_rng([seed, number])
        modulus = MATERIALS[material] * float(np.exp(SPREAD * random.normal()))
        is_mixed_up = number % MIXED_UP_EVERY == MIXED_UP_EVERY - 1
        modulus *= MIXED_UP if is_mixed_up else 1.0
        truth[name] = {'material': material, 'modulus': modulus, 'is_mixed_up': is_mixed_up}
        if not (folder / name / 'scene.yaml').is_file():
            own = replace(scene.regions[0], youngs_modulus=Quantity(modulus, 5e3, 5e6))
            settings = replace(_SETTINGS, seed=seed + number)
            record(replace(scene, regions=(own,)), folder / name, settings, overwrite=True)
        rows.append([name, f'{name}/scene.yaml', f'{name}/bag', material, OPTIONS])
    (folder / TRUTH).write_text(json.dumps(truth, indent=1) + '\n')
    with (folder / MANIFEST).open('w', newline='') as file:
        writer = csv.writer(file)
        writer.writerows([['body', 'scene', 'recordings', 'material', 'options'], *rows])
    return folder / MANIFEST


def _write_mesh(path: Path) -> None:
    """Cut the beam into boxes of six tetrahedra."""
    axes = [np.linspace(0.0, 1e3 * size, n + 1) for size, n in zip(_SIZE, _COUNTS, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1)
    places = np.arange(points[..., 0].size).reshape(points.shape[:3])
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)]
    corners.append((1, 1, 1))
    ends = tuple(places.shape[k] - 1 for k in range(3))
    of_box = [places[a : a + ends[0], b : b + ends[1], c : c + ends[2]] for a, b, c in corners]
    # Paths from the first corner to the last, one for each order of the axes.
    paths = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]
    tets = np.stack([np.stack([of_box[k].ravel() for k in path], -1) for path in paths], 1)
    lines = [f'v {x} {y} {z}' for x, y, z in points.reshape(-1, 3).tolist()]
    lines += [f't {a} {b} {c} {d}' for a, b, c, d in tets.reshape(-1, 4).tolist()]
    path.write_text('\n'.join(lines) + '\n')
