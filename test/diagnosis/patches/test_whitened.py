# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two models compared patch by patch."""

from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.whitened import excess_over, Part
import numpy as np
import pytest

_FIXTURE = 0.030  # What shows something else than the body is off by that in every model [m].


def group(values, cells=None):
    values = np.asarray(values)
    count = len(values)
    patches = Patches(
        values=values,
        jacobian=np.zeros((count, 0)),
        covariance=np.eye(count),
        centers=np.zeros((count, 2)),
        cells=np.arange(count) if cells is None else np.asarray(cells),
        weights=np.ones(count),
        common=CommonError(np.zeros(count), 1.0),
    )
    return PatchGroup(0, 'depth', 0, patches, np.zeros(count), np.ones(count, dtype=bool))


def test_a_part_that_only_one_model_meets_is_not_outvoted():
    best = [group([0.001] * 8 + [_FIXTURE] * 2)]
    rival = [group([0.001] * 6 + [-0.020] * 2 + [_FIXTURE] * 2)]
    # Two of ten patches, at five millimetres each.
    assert excess_over(rival, best, Part.REPORT) == pytest.approx(0.001)
    assert excess_over(best, rival, Part.REPORT) == pytest.approx(-0.001)


def test_what_no_model_meets_says_nothing():
    best = [group([0.001] * 8 + [_FIXTURE] * 2)]
    rival = [group([-0.0012] * 8 + [_FIXTURE] * 2)]
    assert excess_over(rival, best, Part.REPORT) == pytest.approx(0.8 * 0.0002)


def test_only_patches_that_both_see_are_compared():
    best, rival = [group([0.001, 0.002])], [group([0.009, 0.0025], cells=[7, 1])]
    assert excess_over(rival, best, Part.REPORT) == pytest.approx(0.0005)
    assert np.isnan(excess_over([group([0.001], cells=[7])], best, Part.REPORT))
