# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The marker pose node: the recorded marker is found where it was, and what is wrong is told."""

import json

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.marker import Board, Marker
from diffcal_ros.pose.marker_image import draw_print
from diffcal_ros.pose.marker_print import print_of
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.rigid_transform import angle_between, rotation_matrix, transform
from diffcal_ros.ros.conversion import camera_info_message, image_message, pose_matrix
from diffcal_ros.ros.marker_pose import MarkerPoseNode
from diffcal_ros.scene.load import load_scene
from geometry_msgs.msg import PoseWithCovarianceStamped
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Int32MultiArray

POSE = 'marker_pose: pose'
WARN, ERROR = b'\x01', b'\x02'
FRAME = 'camera_color_optical_frame'
START = 1_700_000_000_000_000_000  # [ns]


def _image(pixels: np.ndarray, number: int = 0) -> Image:
    stamp = START + number * 200_000_000
    return image_message(pixels, encoding='bgr8', time_ns=stamp, frame_id=FRAME)


@pytest.fixture
def seen(recorded_beam):
    """A colour image, its camera, and where the marker truly is in it."""
    (path,) = recorded_beam.bags.values()
    recording = open_recording(path)
    marker = load_scene(recorded_beam.scene).marker
    truth = json.loads(recorded_beam.truth.read_text())
    (observation,) = truth['observations'].values()
    color_from_world = np.linalg.inv(truth['depth_from_color']) @ observation['depth_from_world']
    pixels = next(iter(recording.color_frames())).image
    return pixels, recording.color_camera, color_from_world @ marker.world_from_marker


def test_the_pose_is_the_true_one_and_bad_images_are_told(make_bench, recorded_beam, seen):
    pixels, camera, true_pose = seen
    bench = make_bench({'scene': recorded_beam.scene, 'max_rate': 1000.0})
    poses = bench.collect(PoseWithCovarianceStamped, 'marker_pose/pose')
    parts = bench.collect(Int32MultiArray, 'marker_pose/seen')
    bench.add(MarkerPoseNode)
    info = bench.publisher(CameraInfo, 'color/camera_info')
    color = bench.publisher(Image, 'color/image_raw')
    color.publish(_image(pixels))
    bench.status(POSE, WARN, 'waiting for color/camera_info')
    info.publish(camera_info_message(camera, time_ns=START, frame_id=FRAME))
    bench.status(POSE, WARN, 'waiting for color/image_raw')
    color.publish(_image(np.zeros_like(pixels), 1))
    bench.status(POSE, ERROR, 'marker')
    assert not poses
    color.publish(_image(pixels, 2))
    found = bench.until(lambda: poses, 'a pose')[0]
    assert found.header.frame_id == FRAME
    marker = load_scene(recorded_beam.scene).marker
    assert tuple(bench.until(lambda: parts, 'what was seen')[0].data) == (marker.id,)
    pose = pose_matrix(found.pose.pose)
    shift = np.linalg.norm(pose[:3, 3] - true_pose[:3, 3])
    spread = np.sqrt(np.trace(np.reshape(found.pose.covariance, (6, 6))[:3, :3]))
    assert shift < 4.0 * spread
    assert spread < 0.01 * np.linalg.norm(true_pose[:3, 3])
    odd = _image(pixels, 3)
    odd.encoding = 'bayer_rggb8'
    color.publish(odd)
    bench.status(POSE, ERROR, 'bayer_rggb8')
    unnamed = _image(pixels, 4)
    unnamed.header.frame_id = ''
    color.publish(unnamed)
    bench.status(POSE, ERROR, 'frame_id is empty')
    blind = camera_info_message(camera, time_ns=START, frame_id=FRAME)
    blind.k[0] = blind.p[0] = 0.0
    info.publish(blind)
    bench.status(POSE, ERROR, 'color/')


def test_a_marker_that_cannot_be_is_an_error_until_it_is_changed(make_bench):
    bench = make_bench({'marker.dictionary': 'DICT_9X9_1', 'use_depth': False})
    bench.add(MarkerPoseNode)
    bench.status(POSE, ERROR, 'DICT_9X9_1')
    assert bench.set_parameter('marker_pose', 'marker.dictionary', 'DICT_4X4_50').successful
    bench.status(POSE, WARN, 'waiting for')
    refused = bench.set_parameter('marker_pose', 'marker.id', 1000)
    assert not refused.successful
    assert 'DICT_4X4_50 holds 0 to 49' in refused.reason
    assert bench.set_parameter('marker_pose', 'board.columns', 5).successful
    bench.status(POSE, ERROR, 'board of 5x0 squares')


@pytest.mark.parametrize('is_scene', [True, False])
def test_a_board_is_found_by_the_scene_or_by_parameters(make_bench, write_scene, is_scene):
    board = Board(5, 7, 0.03)
    marker = {'dictionary': 'DICT_4X4_50', 'side': 0.022}
    if is_scene:
        place = {'columns': 5, 'rows': 7, 'square': 0.03}
        parameters = {'scene': write_scene({'marker': {**marker, 'board': place}})}
    else:
        parameters = {f'marker.{name}': value for name, value in marker.items()}
        parameters |= {'board.columns': 5, 'board.rows': 7, 'board.square': 0.03}
    turn = np.array([np.pi * np.cos(0.15), 0.0, np.pi * np.sin(0.15)])
    pose = transform(rotation_matrix(turn), np.array([0.01, -0.02, 0.45]))
    camera = PinholeCamera(640, 480, 605.0, 590.0, 331.5, 226.3)
    sheet = print_of(Marker('DICT_4X4_50', 0, 0.022, board=board))
    blank = np.full((480, 640, 3), 110, np.uint8)
    pixels = draw_print(blank, sheet, camera=camera, camera_from_marker=pose)
    bench = make_bench({**parameters, 'use_depth': False})
    poses = bench.collect(PoseWithCovarianceStamped, 'marker_pose/pose')
    bench.add(MarkerPoseNode)
    info = bench.publisher(CameraInfo, 'color/camera_info')
    color = bench.publisher(Image, 'color/image_raw')
    info.publish(camera_info_message(camera, time_ns=START, frame_id=FRAME))
    bench.status(POSE, WARN, 'waiting for color/image_raw')
    color.publish(_image(pixels))
    found = pose_matrix(bench.until(lambda: poses, 'a pose')[0].pose.pose)
    # The middle of the board, not OpenCV's corner of it.
    np.testing.assert_allclose(found[:3, 3], pose[:3, 3], atol=0.5e-3)
    assert angle_between(found, pose) < np.deg2rad(0.3)


def test_a_scene_without_a_marker_is_an_error(make_bench, write_scene):
    bench = make_bench({'scene': write_scene()})
    bench.add(MarkerPoseNode)
    bench.status(POSE, ERROR, "has no 'marker'")
