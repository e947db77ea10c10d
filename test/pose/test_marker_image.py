# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from dataclasses import replace

import cv2
from diffcal_ros.errors import PoseError
from diffcal_ros.pose.lens import distort, undistort
from diffcal_ros.pose.marker_image import draw_marker
from diffcal_ros.rigid_transform import apply
import numpy as np
import pytest

LENS = (-0.3, 0.12, 0.001, -0.0007, 0.0)
# Eight rays along a pixel's side leave steps of 1/8 in the coverage of a pixel.
AREA_TOLERANCE = 0.01


def draw(camera, pose, target, **options):
    blank = np.full((camera.height, camera.width, 3), 0, np.uint8)
    return draw_marker(
        blank,
        camera=camera,
        camera_from_marker=pose,
        dictionary=target.dictionary,
        marker_id=3,
        side=0.03,
        **options,
    )


def test_print_covers_the_projected_area(color_camera, marker_pose, target):
    pose = marker_pose(35.0)
    image = draw(color_camera, pose, target, black=200, white=200, quiet_zone=0.0)
    corners = color_camera.project(apply(pose, target.corners[3]))
    area = cv2.contourArea(corners.astype(np.float32))
    assert image[..., 0].sum() / 200.0 == pytest.approx(area, rel=AREA_TOLERANCE)
    # The centre of mass of the square's image lies near that of its corners.
    rows, columns = np.nonzero(image[..., 0])
    assert np.hypot(*(corners.mean(axis=0) - [columns.mean(), rows.mean()])) < 1.0


def test_marker_is_read_back(color_camera, marker_pose, target):
    image = draw(color_camera, marker_pose(20.0), target)
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    _, ids, _ = cv2.aruco.ArucoDetector(dictionary).detectMarkers(image)
    assert ids.ravel().tolist() == [3]


def test_distorted_print_is_the_undistorted_one_moved(color_camera, marker_pose, target):
    lens = replace(color_camera, distortion=LENS)
    pose = marker_pose(20.0, column=0.12, row=-0.09)
    image = draw(lens, pose, target, black=200, white=200, quiet_zone=0.0)
    corners = distort(color_camera.project(apply(pose, target.corners[3])), lens)
    assert np.abs(corners - color_camera.project(apply(pose, target.corners[3]))).max() > 1.0
    area = cv2.contourArea(corners.astype(np.float32))
    assert image[..., 0].sum() / 200.0 == pytest.approx(area, rel=AREA_TOLERANCE)


def test_back_of_the_print_is_white(color_camera, marker_pose, target):
    image = draw(color_camera, marker_pose(180.0), target)
    assert set(np.unique(image[220:230, 395:405])) <= {0, 225}
    assert image.max() == 225
    assert (image == 20).sum() == 0


def test_background_shows_around_the_print_only(color_camera, marker_pose, target, random):
    background = random.integers(0, 255, (480, 640, 3)).astype(np.uint8)
    image = draw_marker(
        background,
        camera=color_camera,
        camera_from_marker=marker_pose(0.0),
        dictionary=target.dictionary,
        marker_id=3,
        side=0.03,
    )
    changed = (image != background).any(axis=2)
    assert 0 < changed.sum() < 80 * 80
    np.testing.assert_array_equal(image[:100], background[:100])


def test_print_outside_the_view_changes_nothing(color_camera, marker_pose, target):
    assert draw(color_camera, marker_pose(0.0, column=0.6), target).max() == 0


def test_marker_behind_the_camera_is_refused(color_camera, marker_pose, target):
    with pytest.raises(PoseError, match='behind the camera'):
        draw(color_camera, marker_pose(0.0, distance=-0.4), target)


def test_background_of_another_size_is_refused(color_camera, marker_pose):
    with pytest.raises(PoseError, match=r'background is \(10, 10, 3\)'):
        draw_marker(
            np.zeros((10, 10, 3), np.uint8),
            camera=color_camera,
            camera_from_marker=marker_pose(0.0),
            dictionary='DICT_6X6_250',
            marker_id=3,
            side=0.03,
        )


def test_undistort_inverts_distort(color_camera):
    lens = replace(color_camera, distortion=LENS)
    pixels = np.stack(np.meshgrid([0.0, 320.0, 639.0], [0.0, 200.0, 479.0]), axis=-1)
    there = undistort(pixels, lens)
    assert np.abs(there - pixels).max() > 5.0
    np.testing.assert_allclose(distort(there, lens), pixels, atol=1e-4)
    assert undistort(pixels, color_camera) is pixels
