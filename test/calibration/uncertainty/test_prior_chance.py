# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How likely a placement is under what the scene states of it."""

from diffcal_ros.calibration.parameters.parameters import Kind, Parameter, ParameterSet
from diffcal_ros.calibration.uncertainty.prior_chance import placement_chance
from diffcal_ros.scene.model import Quantity
import numpy as np
import pytest
from scipy.stats import norm

MODULUS = Parameter(
    'youngs_modulus', Kind.YOUNGS_MODULUS, 0, 'Pa', Quantity(1e5, 1e3, 1e7, 1e5, 1e3)
)


def offset(axis, std):
    known = Quantity(0.0, -1.0, 1.0, 0.0, std)
    return Parameter(f'rigid_offset.{axis}', Kind.RIGID_OFFSET, 0, 'm', known, axis=axis)


def pose(axis):
    free = Quantity(0.0, -1.0, 1.0)
    return Parameter(f'camera_pose.0.{axis}', Kind.CAMERA_POSE, 0, 'm', free, axis=axis)


def test_of_one_stated_number_it_is_that_of_the_normal_distribution():
    parameters = ParameterSet((MODULUS, offset(0, 0.02)))
    for far in (0.0, 0.02, 0.05, -0.1):
        # The modulus is ten of its own deviations off, which is no matter of placement.
        found = placement_chance(parameters, np.array([np.log(1.1e5), far]))
        assert found == pytest.approx(2.0 * norm.sf(abs(far) / 0.02))


def test_of_a_pose_its_covariance_counts(random):
    size = random.normal(size=(6, 6))
    covariance = 1e-4 * (size @ size.T + np.eye(6))
    parameters = ParameterSet(
        (MODULUS, *(pose(axis) for axis in range(6))), pose_covariances=((0, covariance),)
    )
    draws = random.multivariate_normal(np.zeros(6), covariance, size=2000)
    chances = [placement_chance(parameters, np.concatenate([[np.log(1e5)], own])) for own in draws]
    # Of what is drawn as stated the chance is uniform: a tenth lies below a tenth.
    for level in (0.1, 0.5, 0.9):
        assert np.mean(np.array(chances) < level) == pytest.approx(level, abs=0.04)


def test_where_nothing_is_stated_anything_may_be():
    parameters = ParameterSet((MODULUS, pose(0)))
    assert placement_chance(parameters, np.array([0.0, 0.9])) == 1.0
