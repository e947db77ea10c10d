# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from diffcal_ros.errors import PoseError
from diffcal_ros.pose.detection import MarkerDetector
from diffcal_ros.pose.running_pose import RunningPose
import numpy as np
import pytest

# Edges on rendered markers: measured 0.1 to 0.5 mm.
WITHIN = 1.5e-3


@pytest.fixture
def running(target, color_camera):
    return RunningPose(MarkerDetector(target, color_camera), window=6)


def distance(fused, pose):
    return np.linalg.norm(fused.camera_from_marker[:3, 3] - pose[:3, 3])


def test_pose_settles_and_the_window_bounds_what_is_kept(running, marker_pose, photograph):
    pose = marker_pose(30.0)
    counts = [running.add(photograph(pose)).frame_count for _ in range(9)]
    assert counts == [1, 2, 3, 4, 5, 6, 6, 6, 6]
    assert distance(running.pose, pose) < WITHIN
    assert running.problem is None
    assert 3 in running.detection.corners


def test_frames_without_a_marker_keep_the_pose_and_say_why(running, marker_pose, photograph):
    blank = np.full((480, 640, 3), 110, np.uint8)
    assert running.add(blank) is None
    assert 'never seen' in running.problem
    fused = running.add(photograph(marker_pose(30.0)))
    assert running.add(blank) is fused
    assert 'never seen' in running.problem


def test_moved_camera_is_followed_and_one_bad_frame_is_not(
    target, color_camera, marker_pose, photograph
):
    running = RunningPose(MarkerDetector(target, color_camera), window=30)
    pose, moved = marker_pose(30.0), marker_pose(25.0, column=-0.05)
    for _ in range(12):
        running.add(photograph(pose))
    assert distance(running.add(photograph(moved)), pose) < WITHIN
    for _ in range(4):
        running.add(photograph(moved))
    assert distance(running.pose, moved) < WITHIN
    assert running.pose.outlier_count == 0
    assert running.pose.frame_count == 5


def test_reset_forgets(running, marker_pose, photograph):
    running.add(photograph(marker_pose(30.0)))
    running.reset()
    assert running.pose is None
    assert running.add(photograph(marker_pose(30.0))).frame_count == 1


def test_window_must_hold_a_frame(target, color_camera):
    with pytest.raises(PoseError, match='window is 0 frames'):
        RunningPose(MarkerDetector(target, color_camera), window=0)
