# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The pose of a marker that has arrived, checked against the depth on what was seen of it."""

from dataclasses import replace

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import PoseError
from diffcal_ros.live.inputs import CameraTransform, LiveInputs
from diffcal_ros.marker import Board, Marker
from diffcal_ros.pose.target import target_of
from diffcal_ros.rigid_transform import apply, inverse, rotation_matrix, transform
from diffcal_ros.scene.model import PoseSetup
from diffcal_ros.stamped_pose import StampedPose
import numpy as np
import pytest
from support.scenes import beam_scene, EXACT_POSE

CAMERA = PinholeCamera(320, 240, 240.0, 236.0, 158.0, 123.0)
DEPTH, COLOR = 'depth_camera', 'color_camera'
DEPTH_FROM_COLOR = transform(
    rotation_matrix(np.array([0.03, -0.02, 0.01])), np.array([0.014, 0, 0])
)
COLOR_FROM_BOARD = transform(
    rotation_matrix(np.array([np.pi - 0.4, 0.1, 0.0])), np.array([-0.01, 0.0, 0.35])
)
BOARD = Marker('DICT_4X4_50', 0, 0.015, board=Board(5, 7, 0.02))
# Above it the board is covered [m], in its own frame.
COVER = -0.04
SCENE = replace(beam_scene(), marker=BOARD)


def covered_board():
    """Depth of a board of which six sevenths lie behind something 8 % nearer."""
    depth_from_board = DEPTH_FROM_COLOR @ COLOR_FROM_BOARD
    normal, rays = depth_from_board[:3, 2], CAMERA.rays()
    depth = (normal @ depth_from_board[:3, 3]) / (rays @ normal)
    place = apply(inverse(depth_from_board), depth[..., None] * rays)
    covered = np.where(place[..., 1] > COVER, 0.92 * depth, depth)
    return DepthFrame(covered.astype(np.float32), 0, DEPTH)


def inputs_with(covariance, scene=SCENE):
    inputs = LiveInputs(scene, 'estimated', '')
    inputs.set_camera(CAMERA)
    inputs.pose = StampedPose(COLOR_FROM_BOARD, covariance, COLOR)
    inputs.transform = CameraTransform(DEPTH_FROM_COLOR, DEPTH, COLOR)
    return inputs


def test_depth_is_looked_at_where_the_board_was_seen_alone():
    inputs = inputs_with(np.eye(6))
    film = (covered_board(),)
    with pytest.raises(PoseError, match="board's square in the scene is wrong"):
        inputs.snapshot(film).observe(SCENE)
    areas = target_of(BOARD).areas
    inputs.seen_ids = tuple(
        n for n, corners in areas.items() if corners[:, 1].max() < COVER + 1e-6
    )
    assert inputs.seen_ids
    (seen,) = inputs.snapshot(film).observe(SCENE)
    expected = DEPTH_FROM_COLOR @ COLOR_FROM_BOARD @ inverse(BOARD.world_from_marker)
    np.testing.assert_allclose(seen.depth_from_world, expected, atol=1e-12)


def _seen_with(pose):
    (setup,) = SCENE.observations
    own = replace(setup, pose=pose)
    scene = replace(SCENE, observations=(own,))
    inputs = inputs_with(None, scene)
    inputs.seen_ids = ()
    ((seen,), notes) = inputs.snapshot((covered_board(),)).take(scene)
    return seen, notes


def test_a_marker_without_covariance_is_exact_where_the_scene_says_so():
    seen, notes = _seen_with(EXACT_POSE)
    assert seen.pose_covariance is None
    assert notes == ()


def test_a_marker_without_covariance_is_known_as_the_scene_says():
    seen, notes = _seen_with(PoseSetup())
    assert seen.pose_covariance[0, 0] == pytest.approx(1e-6)
    assert 'the pose of the marker is taken to be known to 1 mm and 0.3 deg' in notes[0]
