# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The camera's pose from other markers than ArUco's own: AprilTags, ChArUco boards."""

from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support import board_beam
from support.recorded_beam import record_beam

# A tag of 30 mm at 0.4 m, 70 px wide, from two frames: a quarter of a pixel is 1.5 mm of distance.
_SHIFT = 3e-3
_TURN = np.deg2rad(1.5)


def _pose_error(recorded) -> tuple[float, float]:
    inputs = open_inputs(load_scene(recorded.scene), list(recorded.bags.values()))
    return board_beam.pose_error(recorded, inputs.observations[0].depth_from_world)


@pytest.mark.parametrize('dictionary', ['DICT_APRILTAG_36h11', 'DICT_4X4_50'])
def test_the_camera_is_found_from_another_family(tmp_path, dictionary) -> None:
    marker = {'dictionary': dictionary, 'id': 3, 'side': 0.03}
    shift, turn = _pose_error(record_beam(tmp_path, {'marker': marker}))
    assert shift < _SHIFT
    assert turn < _TURN


def test_the_camera_is_found_from_a_board_that_the_body_covers_partly(tmp_path) -> None:
    shift, turn = _pose_error(board_beam.record_board_beam(tmp_path))
    assert shift < board_beam.SHIFT
    assert turn < board_beam.TURN
