# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where synthetic cameras stand: everything in view, the marker from its front."""

from diffcal_ros.errors import InputError
from diffcal_ros.marker import Marker
from diffcal_ros.rigid_transform import apply, check_rigid, inverse, rotation_matrix, transform
from diffcal_ros.synthetic.viewpoint import (
    COLOR_CAMERA,
    color_from_world,
    default_view,
    DEPTH_CAMERA,
    sees,
    view_from,
)
import numpy as np
import pytest

GRAVITY = np.array([0.0, -9.81, 0.0])
CORNERS = np.stack(np.meshgrid([-0.15, 0.02], [-0.09, 0.0], [-0.04, 0.01]), -1).reshape(-1, 3)
LEFT = np.array([-1.0, 0.0, 0.0])


@pytest.mark.parametrize('size', [0.3, 1.0, 4.0])
@pytest.mark.parametrize('outward', [LEFT, -LEFT])
def test_both_cameras_see_everything_and_not_from_far_away(size, outward):
    points = size * CORNERS
    pose = default_view(points, outward, GRAVITY, None, DEPTH_CAMERA, COLOR_CAMERA)
    check_rigid('depth_from_world', pose)
    assert sees(DEPTH_CAMERA, pose, points)
    assert sees(COLOR_CAMERA, color_from_world(pose), points)
    depths = apply(pose, points)[:, 2]
    assert depths.min() >= 0.26 - 1e-9
    spans = [
        np.ptp(camera.project(apply(p, points)), axis=0) / (camera.width, camera.height)
        for camera, p in ((DEPTH_CAMERA, pose), (COLOR_CAMERA, color_from_world(pose)))
    ]
    # The picture is filled, but for what the sensor's range holds back.
    assert np.max(spans) > 0.5 or depths.min() < 0.27


@pytest.mark.parametrize('turn', [0.0, 1.0, 3.0])
def test_the_marker_is_seen_from_its_front_at_an_angle(turn):
    """A marker seen squarely has two poses that look alike."""
    rotation = rotation_matrix(np.array([0.0, turn, 0.0]))
    marker = Marker('DICT_6X6_250', 0, 0.03, transform(rotation, np.zeros(3)))
    pose = default_view(CORNERS, LEFT, GRAVITY, marker, DEPTH_CAMERA, COLOR_CAMERA)
    to_camera = inverse(pose)[:3, 3]
    cosine = float(rotation[:, 2] @ to_camera / np.linalg.norm(to_camera))
    assert np.deg2rad(15.0) < np.arccos(cosine) < np.deg2rad(50.0)


def test_the_camera_stands_on_the_bodys_side_and_above():
    for outward in (LEFT, -LEFT):
        pose = default_view(CORNERS, outward, GRAVITY, None, DEPTH_CAMERA, COLOR_CAMERA)
        from_middle = inverse(pose)[:3, 3] - CORNERS.mean(axis=0)
        assert from_middle @ outward > 0.0
        assert from_middle[1] > 0.0
        # Down in the world is down in the picture.
        assert (pose[:3, :3] @ GRAVITY)[1] > 0.0


def test_a_given_place_looks_at_the_middle():
    position = np.array([0.1, 0.05, 0.4])
    pose = view_from(position, CORNERS, GRAVITY)
    np.testing.assert_allclose(inverse(pose)[:3, 3], position, atol=1e-12)
    middle = 0.5 * (CORNERS.min(axis=0) + CORNERS.max(axis=0))
    np.testing.assert_allclose(apply(pose, middle)[:2], 0.0, atol=1e-12)


@pytest.mark.parametrize('offset', [(0.0, 0.3, 0.0), (0.0, 0.0, 0.0)])
def test_a_place_straight_above_or_inside_is_refused(offset):
    middle = 0.5 * (CORNERS.min(axis=0) + CORNERS.max(axis=0))
    with pytest.raises(InputError, match=r'straight above, below or in .* move it to a side'):
        view_from(middle + offset, CORNERS, GRAVITY)


def test_a_camera_does_not_see_what_is_behind_it():
    pose = view_from(np.array([0.0, 0.0, 0.4]), CORNERS, GRAVITY)
    turned = transform(rotation_matrix(np.array([0.0, np.pi, 0.0])), np.zeros(3)) @ pose
    assert sees(DEPTH_CAMERA, pose, CORNERS)
    assert not sees(DEPTH_CAMERA, turned, CORNERS)
