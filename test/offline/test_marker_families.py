# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The camera's pose from markers of other families than ArUco's own."""

import json

from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.recorded_beam import record_beam

# A tag of 30 mm at 0.4 m, 70 px wide, from two frames: a quarter of a pixel is 1.5 mm of distance.
_SHIFT = 3e-3
_TURN = np.deg2rad(1.5)


@pytest.mark.parametrize('dictionary', ['DICT_APRILTAG_36h11', 'DICT_4X4_50'])
def test_the_camera_is_found_from_another_family(tmp_path, dictionary) -> None:
    marker = {'dictionary': dictionary, 'id': 3, 'side': 0.03}
    recorded = record_beam(tmp_path, {'marker': marker})
    inputs = open_inputs(load_scene(recorded.scene), list(recorded.bags.values()))
    truth = json.loads(recorded.truth.read_text())['observations']
    (expected,) = (np.array(own['depth_from_world']) for own in truth.values())
    error = inputs.observations[0].depth_from_world @ np.linalg.inv(expected)
    assert np.linalg.norm(error[:3, 3]) < _SHIFT
    assert np.arccos(np.clip((np.trace(error[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)) < _TURN
