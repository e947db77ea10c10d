# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which noise patches have: measured, stated or believed."""

from dataclasses import replace

from diffcal_ros.diagnosis.patches.noise_model import noise_of
from diffcal_ros.scene.model import DepthSensor
import numpy as np
import pytest
from support.watched import watched


@pytest.fixture(scope='module')
def seen():
    return watched(seed=1)


@pytest.mark.parametrize('frame_count', [1, 5])
def test_a_stated_smooth_error_goes_before_what_is_believed(seen, frame_count):
    own = replace(seen, frame_count=frame_count, noise=0.0002 if frame_count > 1 else np.nan)
    usual, stated = DepthSensor(), DepthSensor(smooth_error=0.0011)
    assert noise_of(own, stated).smooth == 0.0011
    assert noise_of(own, usual).smooth == (0.0002 if frame_count > 1 else 0.0005)
    # Nothing else is another one.
    bare = [replace(noise_of(own, of), smooth=0.0, is_stated=False) for of in (stated, usual)]
    assert bare[0] == bare[1]


def test_patches_of_a_stated_smooth_error_are_off_together(seen):
    centers = np.array([[100.0, 100.0], [104.0, 100.0], [300.0, 200.0]])
    own = replace(seen, frame_count=5, noise=0.0002)
    noise = noise_of(own, DepthSensor(smooth_error=0.0011))
    covariance = noise.depth_covariance(centers, np.full(3, 400.0))
    assert covariance[0, 1] == pytest.approx(0.0011**2, rel=0.01)
    assert covariance[0, 2] < 0.01 * covariance[0, 1]


def test_an_average_over_few_pixels_that_share_their_noise_is_known_as_one(seen):
    own = replace(seen, frame_count=5, noise=0.0004, grain=20.0)
    centers, counts = np.array([[0.0, 0.0], [900.0, 0.0]]), np.array([80.0, 10.0])
    exact = DepthSensor(quantization=0.0)
    white = noise_of(replace(own, grain=1.0), exact).depth_covariance(centers, counts)
    shared = noise_of(own, exact).depth_covariance(centers, counts)
    more = np.diag(shared - white)
    np.testing.assert_allclose(more, 0.0004**2 * np.array([19.0 / 80.0, 0.9]), rtol=1e-9)
    assert shared[0, 1] == white[0, 1], 'that is of neighbours within a patch'


def test_rounding_is_each_pixels_own(seen):
    own = replace(seen, frame_count=5, noise=0.0004, grain=20.0)
    stepped = DepthSensor(quantization=0.004)
    rounding = 0.004 / np.sqrt(60.0)
    told = noise_of(own, stepped)
    assert told.pixel**2 * told.grain == pytest.approx(20.0 * 0.0004**2 + rounding**2)


def test_what_too_few_frames_show_of_grain_is_not_believed(seen):
    assert (
        noise_of(replace(seen, frame_count=2, noise=0.0004, grain=20.0), DepthSensor()).grain == 1
    )
