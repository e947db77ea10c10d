# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Live, a board's pose and the depth on it become the camera's pose as a marker's do."""

from diffcal_ros.live.inputs import CameraTransform, LiveInputs
from diffcal_ros.live.marker_tracker import MarkerTracker
from diffcal_ros.pose.detection import CornerRefinement
from diffcal_ros.pose.marker_depth import DepthEvidence
from diffcal_ros.pose.target import target_of
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.scene.load import load_scene
from diffcal_ros.stamped_pose import StampedPose
from support.board_beam import pose_error, record_board_beam, SHIFT, TURN


def test_colour_and_depth_of_a_partly_covered_board_give_the_camera(tmp_path):
    recorded = record_board_beam(tmp_path)
    scene = load_scene(recorded.scene)
    recording = open_recording(recorded.bags['observation'])
    frames = tuple(recording.depth_frames())
    evidence = DepthEvidence(frames[-1].depth, recording.depth_camera, recording.depth_from_color)
    tracker = MarkerTracker(target_of(scene.marker), window=30, refinement=CornerRefinement.EDGES)
    tracker.set_camera(recording.color_camera)
    colors = list(recording.color_frames())
    poses = [tracker.add(color.image, color.stamp_ns, evidence) for color in colors]
    assert tracker.health().message == f'pose from {len(colors)} frames'
    inputs = LiveInputs(scene, 'estimated', '')
    inputs.set_camera(recording.depth_camera)
    frame_id = colors[0].frame_id
    inputs.pose = StampedPose(poses[-1].camera_from_marker, poses[-1].covariance, frame_id)
    inputs.transform = CameraTransform(recording.depth_from_color, frames[0].frame_id, frame_id)
    (observation,) = inputs.snapshot(frames).observe(scene)
    shift, turn = pose_error(recorded, observation.depth_from_world)
    assert shift < SHIFT
    assert turn < TURN
