# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from diffcal_ros.pose.planar_pose import pose_candidates, reprojection_error
from diffcal_ros.rigid_transform import angle_between, apply
import numpy as np
import pytest

EXACT = 1e-6  # Metres and radians; double precision through OpenCV's solver.


def line_of_sight_tilt(pose):
    return np.arccos(-pose[:3, 2] @ pose[:3, 3] / np.linalg.norm(pose[:3, 3]))


@pytest.mark.parametrize('tilt', [15.0, 40.0, 65.0])
def test_exact_corners_give_the_exact_pose_first_and_its_mirror_image_second(
    color_camera, target, marker_pose, tilt
):
    pose = marker_pose(tilt, distance=0.5)
    points = target.corners[3]
    pixels = color_camera.project(apply(pose, points))
    best, mirrored = pose_candidates(points, pixels, color_camera)
    np.testing.assert_allclose(best.camera_from_marker, pose, atol=EXACT)
    assert best.error < 1e-4 < mirrored.error
    # The two see the marker equally tilted, about the line of sight.
    assert line_of_sight_tilt(mirrored.camera_from_marker) == pytest.approx(
        line_of_sight_tilt(pose), abs=np.deg2rad(3.0)
    )
    assert angle_between(mirrored.camera_from_marker, pose) > np.deg2rad(tilt)
    assert mirrored.error == pytest.approx(
        reprojection_error(mirrored.camera_from_marker, points, pixels, color_camera)
    )


def test_solid_target_has_one_pose(color_camera, marker_pose, random):
    points = random.uniform(-0.03, 0.03, (8, 3))
    pose = marker_pose(30.0)
    pixels = color_camera.project(apply(pose, points))
    candidates = pose_candidates(points, pixels, color_camera)
    np.testing.assert_allclose(candidates[0].camera_from_marker, pose, atol=EXACT)


def test_flat_target_off_its_origin(color_camera, target, marker_pose):
    points = target.corners[3] + [0.02, -0.05, 0.01]
    pose = marker_pose(30.0)
    pixels = color_camera.project(apply(pose, points))
    best = pose_candidates(points, pixels, color_camera)[0]
    np.testing.assert_allclose(best.camera_from_marker, pose, atol=EXACT)
