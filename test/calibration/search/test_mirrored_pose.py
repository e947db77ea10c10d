# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two camera poses under which a flat marker looks alike: the body tells which it is."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.pose.planar_pose import pose_candidates
from diffcal_ros.rigid_transform import apply
import numpy as np
import pytest
from support.scenes import (
    beam_scene,
    CAMERA,
    DEPTH_FROM_WORLD,
    MODULUS,
    noisy,
    observation,
    true_depth,
)

_QUICK = CalibrationSettings(with_mesh_error=False)
_HALF = 0.01  # Of the marker's side [m].
_CORNERS = np.array(
    [[-_HALF, _HALF, 0.0], [_HALF, _HALF, 0.0], [_HALF, -_HALF, 0.0], [-_HALF, -_HALF, 0.0]]
)


def _two_poses() -> tuple[np.ndarray, np.ndarray]:
    """Return the true pose of the world in the camera and the marker's other one, by OpenCV."""
    pixels = CAMERA.project(apply(DEPTH_FROM_WORLD, _CORNERS))
    one, two = pose_candidates(_CORNERS, pixels, CAMERA)
    poses = sorted(
        (one.camera_from_marker, two.camera_from_marker),
        key=lambda pose: float(np.abs(pose - DEPTH_FROM_WORLD).max()),
    )
    return poses[0], poses[1]


@pytest.mark.parametrize('is_given_first', [pytest.param(True, marks=pytest.mark.slow), False])
def test_the_body_tells_which_pose_is_the_markers(random, is_given_first) -> None:
    true, mirrored = _two_poses()
    assert np.abs(mirrored - true).max() > 0.2
    given, other = (true, mirrored) if is_given_first else (mirrored, true)
    seen = observation(noisy(true_depth(), random), pose=given)
    scene = beam_scene(modulus=3.0 * MODULUS, fit=('youngs_modulus', 'rigid_offset'))
    result = calibrate(scene, [replace(seen, mirrored=other)], _QUICK)
    assert result.outcome is Outcome.CONVERGED
    assert result['youngs_modulus'].value == pytest.approx(MODULUS, rel=0.04)
    told = any('mirrored pose has it' in warning for warning in result.warnings)
    assert told is not is_given_first


@pytest.mark.slow
def test_a_wrong_pose_alone_is_not_called_converged(random) -> None:
    _, mirrored = _two_poses()
    seen = observation(noisy(true_depth(), random), pose=mirrored)
    scene = beam_scene(modulus=3.0 * MODULUS, fit=('youngs_modulus', 'rigid_offset'))
    result = calibrate(scene, [seen], _QUICK)
    assert result.outcome is not Outcome.CONVERGED
    assert result.outcome.exit_code != 0
