# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recordings whose body was placed anew before each: every one has an offset of its own."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import calibrate, Calibration
from diffcal_ros.calibration.observations.observation import Observation, pose_covariances
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError
from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.model import Scene
import numpy as np
import pytest
from support.scenes import beam_scene, DEPTH_FROM_WORLD, MODULUS, observation, true_depth

_QUICK = CalibrationSettings(with_mesh_error=False, search=False)
# Wrong by these [m, rad], one after the other.
_OFF = (
    transform(rotation_matrix(np.array([0.02, -0.03, 0.0])), np.array([0.004, 0.003, 0.006])),
    transform(rotation_matrix(np.array([-0.03, 0.02, 0.0])), np.array([-0.005, 0.002, -0.006])),
)


def _scene(**offset) -> Scene:
    scene = beam_scene((8, 2, 2), modulus=70e3, fit=('youngs_modulus', 'rigid_offset'))
    return replace(scene, rigid_offset=replace(scene.rigid_offset, **offset))


@pytest.fixture(scope='module')
def observations() -> list[Observation]:
    seen = observation(true_depth())
    return [
        replace(seen, name=str(k), depth_from_world=off @ DEPTH_FROM_WORLD)
        for k, off in enumerate(_OFF)
    ]


def test_each_recording_finds_its_own(observations) -> None:
    shared = calibrate(_scene(), observations, _QUICK)
    own = calibrate(_scene(each_recording=True), observations, _QUICK)
    assert own.gap_end.rms < 0.2 * shared.gap_end.rms
    assert own['youngs_modulus'].value == pytest.approx(MODULUS, rel=0.05)
    for number, off in enumerate(_OFF):
        turn = [own[f'camera_pose.{number}.{axis}'].value for axis in ('rx', 'ry')]
        expected = [-0.5 * (off[2, 1] - off[1, 2]), -0.5 * (off[0, 2] - off[2, 0])]
        np.testing.assert_allclose(turn, expected, atol=6e-3)


def test_nothing_is_fitted_that_was_not_asked_for(observations) -> None:
    fixed = Calibration(
        replace(_scene(each_recording=True), fit=('youngs_modulus',)), observations, _QUICK
    )
    assert not fixed.parameters.find(Kind.CAMERA_POSE)
    free = Calibration(_scene(each_recording=True), observations, _QUICK)
    assert len(free.parameters.find(Kind.CAMERA_POSE)) == 12
    assert not free.parameters.find(Kind.RIGID_OFFSET)


def test_own_offset_is_added_to_what_is_known_of_the_pose(observations) -> None:
    own, known = np.eye(6), 0.01 * np.eye(6)
    both = pose_covariances(
        [replace(observations[0], pose_covariance=known), observations[1]], own
    )
    np.testing.assert_allclose(both[0], own + known)
    np.testing.assert_allclose(both[1], own)
    assert pose_covariances(observations) == [None, None]


def test_whole_image_losses_have_none(observations) -> None:
    with pytest.raises(InputError, match='knows no offset of each recording'):
        calibrate(_scene(each_recording=True), observations, CalibrationSettings(loss='l1'))
