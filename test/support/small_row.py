# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A small experiment of our own: a beam that is filmed and fitted within seconds."""

from typing import Any

from support.recorded_beam import MODULUS

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
