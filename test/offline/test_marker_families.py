# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The camera's pose from other markers than ArUco's own: AprilTags, ChArUco boards."""

import json

from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.recorded_beam import record_beam

# A tag of 30 mm at 0.4 m, 70 px wide, from two frames: a quarter of a pixel is 1.5 mm of distance.
_TAG_SHIFT, _TAG_TURN = 3e-3, np.deg2rad(1.5)
# A board of 144 x 168 mm, its squares 30 px wide, a third behind the beam: measured 0.7 mm and
# 0.13 degrees.
_BOARD_SHIFT, _BOARD_TURN = 1e-3, np.deg2rad(0.3)


def _pose_error(recorded) -> tuple[float, float]:
    """Record, and tell how far [m] and by what angle [rad] the found camera is off."""
    inputs = open_inputs(load_scene(recorded.scene), list(recorded.bags.values()))
    truth = json.loads(recorded.truth.read_text())['observations']
    (expected,) = (np.array(own['depth_from_world']) for own in truth.values())
    error = inputs.observations[0].depth_from_world @ np.linalg.inv(expected)
    cosine = np.clip((np.trace(error[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)
    return float(np.linalg.norm(error[:3, 3])), float(np.arccos(cosine))


@pytest.mark.parametrize('dictionary', ['DICT_APRILTAG_36h11', 'DICT_4X4_50'])
def test_the_camera_is_found_from_another_family(tmp_path, dictionary) -> None:
    marker = {'dictionary': dictionary, 'id': 3, 'side': 0.03}
    shift, turn = _pose_error(record_beam(tmp_path, {'marker': marker}))
    assert shift < _TAG_SHIFT
    assert turn < _TAG_TURN


def test_the_camera_is_found_from_a_board_that_the_body_covers_partly(tmp_path) -> None:
    marker = {
        'board': {'columns': 6, 'rows': 7, 'square': 0.024},
        'dictionary': 'DICT_4X4_50',
        'side': 0.018,
        # Behind the beam.
        'placement': {'translation': [-0.03, -0.03, -0.08]},
    }
    recorded = record_beam(tmp_path, {'marker': marker})
    shift, turn = _pose_error(recorded)
    assert shift < _BOARD_SHIFT
    assert turn < _BOARD_TURN
