# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A small experiment of our own: a beam that is filmed and fitted within seconds."""

from pathlib import Path
from typing import Any

import yaml

from support.recorded_beam import MODULUS, write_beam_scene

ROW: dict[str, Any] = {
    'title': 'a small beam',
    'scene_file': 'true_scene.yaml',
    'simulate': {
        'frames': 2,
        'color_frames': 1,
        'truth': {
            'camera': {'width': 320, 'height': 240, 'fx': 232, 'fy': 235, 'cx': 162, 'cy': 117}
        },
    },
    'start': {'youngs_modulus': [0.6 * MODULUS, 1.7 * MODULUS]},
    'paper': {'youngs_modulus': MODULUS, 'iterations': 100},
    'variants': [
        {'name': 'plain', 'title': 'as it is'},
        {'name': 'coarse', 'title': 'every second pixel', 'pixel_step': 2, 'starts': 1},
    ],
}


def write_row(folder: Path) -> Path:
    """Write the experiment and its scene; return its YAML file."""
    write_beam_scene(folder)
    path = folder / 'small.yaml'
    path.write_text(yaml.safe_dump(ROW))
    return path
