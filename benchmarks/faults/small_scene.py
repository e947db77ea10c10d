# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cantilever of a few tetrahedra and its recording: what a command works on for a second."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.recorder import record, RecorderSettings
import yaml

from benchmarks.live_scene import MODULUS, write_scene

_CELLS = (8, 2, 2)
_CAMERA = {'width': 320, 'height': 240, 'fx': 232, 'fy': 235, 'cx': 162, 'cy': 117}
_COLOR_CAMERA = PinholeCamera(480, 320, 340.0, 338.0, 241.5, 158.75)


@dataclass(frozen=True)
class SmallScene:
    """Files of the body.

    Attributes:
        true_scene: whose start values are the truth.
        scene: the scene of the recording, which it names, started elsewhere.
        bag: the recording.
        row: an experiment for `diffcal reproduce`.
    """

    true_scene: Path
    scene: Path
    bag: Path
    row: Path


def make_small_scene(folder: Path) -> SmallScene:
    """Write scene, recording and experiment into a folder."""
    true_scene = write_scene(folder / 'true', Element.LINEAR, _CELLS)
    document: dict[str, Any] = yaml.safe_load(true_scene.read_text())
    document.update(
        camera=_CAMERA,
        fit=['youngs_modulus'],
        marker={'dictionary': 'DICT_6X6_250', 'id': 7, 'side': 0.03},
        placement={'translation': [-0.155, -0.055, -0.035]},
    )
    true_scene.write_text(yaml.safe_dump(document))
    settings = RecorderSettings(
        timing=Timing(3), color_frames=1, color_camera=_COLOR_CAMERA, element=Element.LINEAR
    )
    recorded = record(load_scene(true_scene), folder / 'recorded', settings)
    (bag,) = recorded.bags.values()
    row = true_scene.parent / 'small.yaml'
    row.write_text(
        yaml.safe_dump(
            {
                'title': 'a small beam',
                'scene_file': true_scene.name,
                'simulate': {'frames': 2, 'color_frames': 1},
                'start': {'youngs_modulus': [0.6 * MODULUS, 1.7 * MODULUS]},
                'paper': {'youngs_modulus': MODULUS, 'iterations': 100},
                'variants': [{'name': 'plain', 'title': 'as it is'}],
            }
        )
    )
    return SmallScene(true_scene, recorded.scene, bag, row)
