# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well a camera's pose is known: in whose frame, and about which point."""

from dataclasses import replace

from diffcal_ros.calibration.observations.camera_pose import (
    CameraPose,
    pose_in_world,
    stated_pose,
    steady_pose,
)
from diffcal_ros.errors import PoseError
from diffcal_ros.rigid_motion import moved
from diffcal_ros.rigid_transform import apply, inverse, rotation_matrix, transform
from diffcal_ros.scene.model import PoseSetup
import numpy as np
import pytest
from support.scenes import DEPTH_FROM_WORLD

POINTS = np.array([[0.1, 0.0, 0.05], [-0.02, 0.03, 0.0], [0.0, -0.1, -0.03]])


def shifted(shift):
    """The pose of a camera that sees everything shifted [m]."""
    return transform(np.eye(3), np.array(shift)) @ DEPTH_FROM_WORLD


def test_a_covariance_in_the_world_is_that_of_what_the_camera_sees(random):
    """Move the camera as the message means it, and what it sees as a fit does."""
    world_from_depth = inverse(DEPTH_FROM_WORLD)
    small = 1e-5 * random.normal(size=6)
    found = pose_in_world(world_from_depth, np.outer(small, small))
    # Of rank one: its root is the movement, but for the sign.
    values, vectors = np.linalg.eigh(found.covariance)
    six = vectors[:, -1] * np.sqrt(values[-1])
    # ROS: fixed axes of the header's frame, about the body's own origin.
    elsewhere = world_from_depth.copy()
    elsewhere[:3, 3] += small[:3]
    elsewhere[:3, :3] = rotation_matrix(small[3:]) @ elsewhere[:3, :3]
    expected = apply(inverse(elsewhere), POINTS)
    seen = apply(found.depth_from_world, POINTS)
    errors = [
        np.abs(moved(seen, sign * six, found.pivot) - expected).max() for sign in (1.0, -1.0)
    ]
    # To first order; what is left is of the order of the movement's square.
    assert min(errors) < 1e-8 < 1e-6 < np.abs(seen - expected).max()


def test_an_explicit_zero_is_exact_and_half_of_one_is_refused():
    exact = stated_pose(DEPTH_FROM_WORLD, PoseSetup(position_std=0.0, rotation_std=0.0), 'it')
    assert exact.covariance is None
    assert exact.notes == ()
    for half in ({'position_std': 0.0}, {'rotation_std': 0.0}, {'position_std': -1.0}):
        with pytest.raises(ValueError, match='two positive numbers, or 0 for both'):
            PoseSetup(**half)


def test_half_of_a_spread_is_told():
    half = stated_pose(DEPTH_FROM_WORLD, PoseSetup(position_std=0.002), 'it')
    assert 'it is taken to be known to 2 mm and 0.3 degrees: state' in half.notes[0]


def test_a_camera_that_stands_still_has_the_pose_in_the_middle():
    poses = [CameraPose(shifted([1e-5 * k, 0, 0])) for k in range(5)]
    assert steady_pose(poses) is poses[2]


@pytest.mark.parametrize(
    ('shift', 'std', 'words'),
    [(0.0004, 0.0, 'changes by 0.4 mm'), (0.004, 0.001, 'is known to 1 mm and 0.0573 degrees')],
)
def test_a_camera_that_moves_is_refused(shift, std, words):
    covariance = np.diag([std**2] * 6) if std else None
    poses = [CameraPose(shifted([k * shift, 0, 0]), covariance, np.zeros(3)) for k in (0, 1)]
    with pytest.raises(PoseError, match=f'{words}.*: hold camera and rig still'):
        steady_pose(poses)


def test_about_a_marker_its_own_movement_counts():
    """A turn about the rig's pivot moves the camera, and not the rig in its view."""
    pivot = DEPTH_FROM_WORLD[:3, 3]
    turn = transform(rotation_matrix(np.array([0.0, 0.02, 0.0])), np.zeros(3))
    about = transform(np.eye(3), pivot) @ turn @ transform(np.eye(3), -pivot)
    known = np.diag([1e-4**2] * 3 + [0.021**2] * 3)
    poses = [
        CameraPose(DEPTH_FROM_WORLD, known, pivot),
        CameraPose(about @ DEPTH_FROM_WORLD, known, pivot),
    ]
    assert steady_pose(poses) is poses[1]
    with pytest.raises(PoseError, match='hold camera'):
        steady_pose([replace(pose, pivot=np.zeros(3)) for pose in poses])
