# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two cameras against one: standard errors fall as the model predicts before the second looks."""

from dataclasses import dataclass

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.expected_information import Candidate, known_after
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.results.result import FittedParameter
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.rigid_transform import looking_at, rotation_matrix, transform
import numpy as np
import pytest
from support.scenes import (
    beam_scene,
    CAMERA,
    DEPTH_FROM_WORLD,
    MODULUS,
    noisy,
    true_depth,
    WORLD_FROM_OBJECT,
)

OTHER_CAMERA = PinholeCamera(280, 260, 310.0, 322.0, 133.5, 140.25)
OTHER_POSE = looking_at(
    np.array([0.07, -0.02, 0.0]), np.array([0.10, 0.16, 0.18]), np.array([0.0, 1.0, 0.2])
)
# What a marker gives: 0.7 mm and 0.4 degrees, each camera's for itself.
POSE_STD = np.array([7e-4] * 3 + [np.deg2rad(0.4)] * 3)
COVARIANCE = np.diag(POSE_STD**2)
# The middle of the held end.
PIVOT = WORLD_FROM_OBJECT @ np.array([0.0, 0.012, 0.009, 1.0])
DRAWS = 8
MANY_DRAWS = 40
SCATTER = 0.30  # Two and a half times the error of a standard deviation of 40 draws.
CLOSE = 0.20  # What the prediction is asked for.
_SETTINGS = CalibrationSettings(with_mesh_error=False)


@dataclass(frozen=True)
class Draw:
    """Young's modulus from one camera, from both, and the error that was predicted for both."""

    alone: FittedParameter
    both: FittedParameter
    predicted: float


def wrong_pose(pose: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return a pose that is off by a draw of its covariance."""
    shift, turn = np.split(random.normal(size=6) * POSE_STD, 2)
    pivot, rotation = (pose @ PIVOT)[:3], rotation_matrix(turn)
    return transform(rotation, pivot - rotation @ pivot + shift) @ pose


def seen(
    name: str,
    depth: np.ndarray,
    camera: PinholeCamera,
    pose: np.ndarray,
    random: np.random.Generator,
) -> Observation:
    """Film with noise and a pose that is somewhat wrong."""
    return Observation(name, 0, noisy(depth, random), camera, wrong_pose(pose, random), COVARIANCE)


def make_draws(count: int) -> list[Draw]:
    """Fit the same beam with noise and poses of their own each time."""
    scene = beam_scene(modulus=1.2 * MODULUS)
    one = true_depth(counts=(8, 2, 2))
    two = true_depth(counts=(8, 2, 2), camera=OTHER_CAMERA, depth_from_world=OTHER_POSE)
    second = Candidate('second', '', scene.observations[0], OTHER_CAMERA, OTHER_POSE, COVARIANCE)
    found = []
    for number in range(count):
        random = np.random.default_rng(number)
        first_seen = seen('first', one, CAMERA, DEPTH_FROM_WORLD, random)
        second_seen = seen('second', two, OTHER_CAMERA, OTHER_POSE, random)
        fit = Calibration(scene, [first_seen], _SETTINGS)
        alone = fit.run()['youngs_modulus']
        known = known_after(fit)
        variance = known.with_candidate(second).covariance[0, 0]
        both = Calibration(scene, [first_seen, second_seen], _SETTINGS).run()['youngs_modulus']
        found.append(Draw(alone, both, alone.value * float(np.sqrt(variance))))
    return found


@pytest.mark.slow
def test_errors_fall_as_predicted() -> None:
    draws = make_draws(DRAWS)
    alone = np.mean([draw.alone.std_error for draw in draws])
    both = np.mean([draw.both.std_error for draw in draws])
    predicted = np.mean([draw.predicted for draw in draws])
    assert both < 0.9 * alone
    assert predicted == pytest.approx(both, rel=CLOSE)


@pytest.mark.slow
def test_errors_are_what_values_scatter_by() -> None:
    draws = make_draws(MANY_DRAWS)
    for name in ('alone', 'both'):
        fitted = [getattr(draw, name) for draw in draws]
        scatter = np.std([p.value for p in fitted], ddof=1)
        assert scatter == pytest.approx(np.mean([p.std_error for p in fitted]), rel=SCATTER)


def test_known_after_a_fit_is_what_the_fit_says() -> None:
    scene = beam_scene(modulus=1.1 * MODULUS)
    random = np.random.default_rng(5)
    fit = Calibration(
        scene, [seen('first', true_depth(), CAMERA, DEPTH_FROM_WORLD, random)], _SETTINGS
    )
    fitted = fit.run()['youngs_modulus']
    own = fitted.value * float(np.sqrt(known_after(fit).covariance[0, 0]))
    assert own == pytest.approx(fitted.std_error, rel=1e-6)
