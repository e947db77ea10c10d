# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two models compared patch by patch."""

from diffcal_ros.diagnosis.patches.patch_gap import excess_over
from diffcal_ros.diagnosis.patches.whitened import Part
import numpy as np
import pytest
from support.unit_patches import unit_group

_FIXTURE = 0.030  # What shows something else than the body is off by that in every model [m].


def test_a_part_that_only_one_model_meets_is_not_outvoted():
    best = [unit_group([0.001] * 8 + [_FIXTURE] * 2)]
    rival = [unit_group([0.001] * 6 + [-0.020] * 2 + [_FIXTURE] * 2)]
    # Two of ten patches, at five millimetres each.
    assert excess_over(rival, best, Part.REPORT) == pytest.approx(0.001)
    assert excess_over(best, rival, Part.REPORT) == pytest.approx(-0.001)


def test_what_no_model_meets_says_nothing():
    best = [unit_group([0.001] * 8 + [_FIXTURE] * 2)]
    rival = [unit_group([-0.0012] * 8 + [_FIXTURE] * 2)]
    assert excess_over(rival, best, Part.REPORT) == pytest.approx(0.8 * 0.0002)


def test_only_patches_that_both_see_are_compared():
    best, rival = [unit_group([0.001, 0.002])], [unit_group([0.009, 0.0025], cells=[7, 1])]
    assert excess_over(rival, best, Part.REPORT) == pytest.approx(0.0005)
    assert np.isnan(excess_over([unit_group([0.001], cells=[7])], best, Part.REPORT))
