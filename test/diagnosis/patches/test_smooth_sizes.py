# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Patches of a sensor whose smooth error is larger than is believed."""

from dataclasses import replace

from diffcal_ros.diagnosis.patches.noise_model import NoiseModel
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.smooth_sizes import (
    log_beliefs,
    size_factors,
    with_larger_error,
)
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
import numpy as np
import pytest

_NOISE = NoiseModel(
    pixel=0.0002, smooth=0.0003, smooth_length=60.0, standing=0.4, is_mixed=True, is_measured=True
)


def _groups(noise: NoiseModel, *, further: float = 0.0) -> list[PatchGroup]:
    """Return patches of two views, and of an outline, by a noise."""
    random, groups = np.random.default_rng(3), []
    for view, kind in ((0, 'depth'), (1, 'depth'), (1, 'edge')):
        centers = random.uniform(0.0, 200.0, (17, 2))
        counts = random.uniform(40.0, 90.0, 17)
        is_depth = kind == 'depth'
        patches = Patches(
            values=1e-4 * random.standard_normal(17),
            jacobian=random.standard_normal((17, 2)),
            covariance=noise.depth_covariance(centers, counts)
            if is_depth
            else noise.edge_covariance(centers, counts, np.full(17, 4e-4)),
            centers=centers,
            cells=np.arange(17),
            weights=counts,
            common=noise.depth_common(17) if is_depth else noise.edge_common(np.full(17, 4e-4)),
            standing=noise.depth_standing(17) if is_depth and noise.standing else None,
        ).doubted(np.full(17, further))
        groups.append(PatchGroup(view, kind, view, patches, np.zeros(17), np.zeros(17, bool)))
    return groups


@pytest.mark.parametrize('common', [0.0, 0.8, 1.0])
@pytest.mark.parametrize('standing', [0.0, 0.4])
def test_they_are_those_that_a_worse_sensor_would_have_given(common, standing):
    noise = replace(_NOISE, common=common, standing=standing)
    worse = replace(noise, smooth=2.5 * noise.smooth)
    found = with_larger_error(_groups(noise), [noise, noise], 2.5)
    expected = _groups(worse)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one.patches.covariance, other.patches.covariance, rtol=1e-12)
        np.testing.assert_allclose(one.patches.variances, other.patches.variances, rtol=1e-12)
    whole = [whiten(groups, Part.ALL).chi_square for groups in (found, expected, _groups(noise))]
    assert whole[0] == pytest.approx(whole[1], rel=1e-9)
    assert whole[0] < 0.99 * whole[2], 'and they say less'


def test_what_else_is_in_doubt_stays():
    further = with_larger_error(_groups(_NOISE, further=0.001), [_NOISE, _NOISE], 2.0)
    alone = with_larger_error(_groups(_NOISE), [_NOISE, _NOISE], 2.0)
    for one, other in zip(further, alone, strict=True):
        more = one.patches.covariance - other.patches.covariance
        np.testing.assert_allclose(np.diag(more), 0.001**2, rtol=1e-9)


def test_what_is_guessed_is_as_large_as_that():
    assert size_factors([_NOISE, replace(_NOISE, is_measured=False)]) == (1.0,)
    assert len(size_factors([_NOISE, _NOISE])) > 3
    assert len(size_factors([replace(_NOISE, is_stated=True)])) > 3


def test_what_is_stated_is_believed_by_itself():
    factors = size_factors([_NOISE])
    small, large = (replace(_NOISE, smooth=size, is_stated=True) for size in (1e-4, 1e-3))
    believed = log_beliefs([small, small], factors)
    np.testing.assert_array_equal(believed, log_beliefs([large, small], factors))
    usual = replace(_NOISE, smooth=NoiseModel.smooth)
    np.testing.assert_array_equal(believed, log_beliefs([usual], factors))
    # Another one that is larger than usual, and is not stated to be, is believed less.
    assert log_beliefs([large, replace(large, is_stated=False)], factors)[0] > believed[0]


def test_a_size_is_believed_the_less_the_farther_it_is_from_what_is_usual():
    factors = size_factors([_NOISE])
    believed = log_beliefs([_NOISE, _NOISE], factors)
    assert np.exp(believed).sum() == pytest.approx(1.0)
    assert np.all(np.diff(believed) < 0.0)
    # Twice the usual size is one standard deviation of the logarithm.
    two = log_beliefs([replace(_NOISE, smooth=NoiseModel.smooth)], (1.0, 2.0))
    assert two[0] - two[1] == pytest.approx(0.5)
