# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a fit hides in a camera's pose of which better is known belongs to the gap."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.diagnosis.patch_fits.strain import unstrained
from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
import numpy as np
import pytest
from support.scenes import beam_scene

_COUNT = 30
# Metres and radians: one standard deviation of each.
_STD = np.array([3e-4, 3e-4, 6e-4, 2e-3, 4e-3, 4e-3])


def fit_with(offset: np.ndarray) -> SimpleNamespace:
    """Make a fit whose only camera is off its stated pose."""
    random = np.random.default_rng(5)
    correlated = np.outer(_STD, _STD) * (0.6 * np.eye(6) + 0.4)
    parameters = make_parameters(beam_scene((6, 2, 2)), pose_covariances=[correlated])
    pose = parameters.find(Kind.CAMERA_POSE)
    coordinates = parameters.start()
    coordinates[pose] = offset
    patches = Patches(
        values=1e-4 * random.standard_normal(_COUNT),
        jacobian=random.standard_normal((_COUNT, len(parameters))),
        covariance=1e-8 * np.eye(_COUNT),
        centers=np.zeros((_COUNT, 2)),
        cells=np.arange(_COUNT),
        weights=np.ones(_COUNT),
        common=CommonError(np.zeros(_COUNT), 1.0),
    )
    group = PatchGroup(0, 'depth', 0, patches, np.zeros(_COUNT), np.zeros(_COUNT, dtype=bool))
    return SimpleNamespace(
        parameters=parameters,
        coordinates=coordinates,
        groups=[group],
        of_the_body=lambda place: (float(coordinates[place]), 1.0),
        covariance=correlated,
        pose=pose,
    )


def sigmas(fit: SimpleNamespace) -> float:
    offset = fit.coordinates[fit.pose]
    return float(np.sqrt(offset @ np.linalg.solve(fit.covariance, offset)))


def test_a_pose_within_its_covariance_hides_nothing():
    fit = fit_with(1.2 * _STD * [1, -1, 1, 1, -1, 1])
    assert 1.5 < sigmas(fit) < 4.4
    assert unstrained(fit) == fit.groups


@pytest.mark.parametrize('times', [4.0, 20.0])
def test_what_a_pose_takes_up_beyond_its_covariance_is_put_back(times):
    direction = _STD * [1.0, 0.3, -0.7, 0.2, 1.0, -0.5]
    fit = fit_with(times * direction)
    (group,) = unstrained(fit)
    put_back = group.patches.values - fit.groups[0].patches.values
    # As unlikely as three standard deviations of one number: 4.479 for six.
    share = 1.0 - 4.479072 / sigmas(fit)
    expected = share * fit.groups[0].patches.jacobian[:, fit.pose] @ (times * direction)
    assert 0.0 < share < 1.0
    assert np.allclose(put_back, expected, rtol=2e-3)


def test_how_large_an_effect_is_that_was_added_hides_nothing():
    """Its usual size says nothing of how large this one may be; stated with a model it does."""
    scene = beam_scene((6, 2, 2))
    nominal = make_parameters(scene, ('youngs_modulus',))
    parameters = make_parameters(scene, ('youngs_modulus', 'depth_affine.bias'))
    fit = fit_with(np.zeros(6))
    index = parameters.names.index('depth_affine.bias')
    usual = list(parameters)[index].quantity.prior_std
    coordinates = parameters.start()
    coordinates[index] = 10.0 * usual
    (group,) = fit.groups
    patches = replace(group.patches, jacobian=np.ones((_COUNT, len(parameters))))
    fit.parameters, fit.coordinates = parameters, coordinates
    fit.groups = [replace(group, patches=patches)]
    fit.of_the_body = lambda place: (float(coordinates[place]), 1.0)
    assert unstrained(fit, nominal) == fit.groups
    (strained,) = unstrained(fit)
    put_back = strained.patches.values - patches.values
    assert np.allclose(put_back, 7.0 * usual)
