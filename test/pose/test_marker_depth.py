# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.marker import Board
from diffcal_ros.pose.board_target import BoardTarget
from diffcal_ros.pose.detection import MarkerDetector
from diffcal_ros.pose.marker_depth import (
    DepthEvidence,
    marker_distance_check,
    points_on_markers,
)
from diffcal_ros.pose.marker_target import single_marker
from diffcal_ros.pose.rig_pose import pose_from_images
from diffcal_ros.rigid_transform import apply, inverse, rotation_matrix, transform
import numpy as np
import pytest

DEPTH_CAMERA = PinholeCamera(320, 240, 240.0, 236.0, 158.0, 123.0)
DEPTH_FROM_COLOR = transform(
    rotation_matrix(np.array([0.03, -0.02, 0.01])), np.array([0.014, -0.003, 0.002])
)


@pytest.fixture
def evidence(marker_pose, plane_depth):
    depth_from_marker = DEPTH_FROM_COLOR @ marker_pose(30.0)
    return DepthEvidence(
        plane_depth(DEPTH_CAMERA, depth_from_marker), DEPTH_CAMERA, DEPTH_FROM_COLOR
    )


def test_points_lie_on_the_marker_and_fill_it(target, marker_pose, evidence):
    pose = marker_pose(30.0)
    measured = points_on_markers(pose, target, evidence)
    on_marker = apply(inverse(pose), measured.points)
    np.testing.assert_allclose(on_marker[:, 2], 0.0, atol=1e-9)
    assert np.abs(on_marker[:, :2]).max() <= 0.015 + 1e-9
    assert np.abs(on_marker[:, :2]).max() > 0.0135
    np.testing.assert_allclose(measured.heights(pose), 0.0, atol=1e-9)
    np.testing.assert_allclose(measured.depth_ratio, 1.0)


def test_heights_are_positive_in_front_of_the_marker(target, marker_pose, evidence):
    farther = marker_pose(30.0, distance=0.41)
    measured = points_on_markers(marker_pose(30.0), target, evidence)
    assert measured.heights(farther).min() > 5e-3


def test_right_side_passes(target, marker_pose, evidence):
    check = marker_distance_check(marker_pose(30.0), target, evidence)
    assert check.relative_error == pytest.approx(0.0, abs=1e-3)
    assert check.pixel_count > 100
    assert check.problem is None
    check.require()


@pytest.mark.parametrize('factor', [0.5, 0.95, 1.05, 2.0, 10.0])
def test_wrong_side_is_found_and_the_right_one_named(
    color_camera, target, photograph, marker_pose, evidence, factor
):
    believed = single_marker('DICT_6X6_250', 3, 0.03 * factor)
    image = photograph(marker_pose(30.0))
    fused = pose_from_images([image], MarkerDetector(believed, color_camera))
    check = marker_distance_check(fused.camera_from_marker, believed, evidence)
    # Looking for the marker at a wrong distance meets the plane beside it.
    assert check.relative_error == pytest.approx(factor - 1.0, rel=0.15)
    with pytest.raises(PoseError, match=r"marker's side in the scene is wrong; \d.\d+ times"):
        check.require()


def test_no_depth_on_the_marker_means_no_check(target, marker_pose):
    hollow = DepthEvidence(np.full((240, 320), np.nan), DEPTH_CAMERA, DEPTH_FROM_COLOR)
    assert marker_distance_check(marker_pose(30.0), target, hollow) is None
    aside = marker_pose(30.0, column=0.9)
    assert marker_distance_check(aside, target, hollow) is None


def test_depth_of_another_size_is_refused():
    with pytest.raises(PoseError, match=r'depth is \(480, 640\), its camera expects \(240, 320\)'):
        DepthEvidence(np.zeros((480, 640)), DEPTH_CAMERA, np.eye(4))


def _check_of_a_covered_board(marker_pose, factor):
    """Two thirds of a board lie behind something 8 % nearer, and nobody says which."""
    board = BoardTarget('DICT_4X4_50', Board(5, 7, 0.02 * factor), 0.015 * factor)
    pose = marker_pose(30.0)
    scaled = transform(pose[:3, :3], factor * pose[:3, 3])
    depth_from_board = DEPTH_FROM_COLOR @ pose
    normal = depth_from_board[:3, 2]
    rays = DEPTH_CAMERA.rays()
    depth = (normal @ depth_from_board[:3, 3]) / (rays @ normal)
    place = apply(inverse(depth_from_board), depth[..., None] * rays)
    depth = np.where(place[..., 1] < 0.02, 0.92 * depth, depth)
    evidence = DepthEvidence(depth, DEPTH_CAMERA, DEPTH_FROM_COLOR)
    return marker_distance_check(scaled, board, evidence)


def test_what_covers_most_of_a_board_does_not_pass_for_it(marker_pose):
    found = _check_of_a_covered_board(marker_pose, 1.0)
    assert found.relative_error == pytest.approx(0.0, abs=5e-3)
    assert found.problem is None


def test_a_covered_board_of_another_size_is_told(marker_pose):
    found = _check_of_a_covered_board(marker_pose, 0.9)
    assert found.relative_error == pytest.approx(-0.1, abs=5e-3)
    with pytest.raises(PoseError, match=r"board's square .* 1\.1[01]\d times it would fit"):
        found.require()
