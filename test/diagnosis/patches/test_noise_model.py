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
