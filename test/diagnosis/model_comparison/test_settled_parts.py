# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parts of a surface are placed anew, and have their heights, once they are in the model."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.settled_parts import settled_parts
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.effects.surface_parts import part_settings, parts_of, SurfacePart
import numpy as np
import pytest
from support.clamped_anew import beam_in_two_poses
from support.watched import with_part

WHOLE = np.array([[-np.inf, np.inf]] * 2)
LAYERS = 12
TRUE = ({'at': 0.7}, {'at': 0.3, 'until': 0.7})
HEIGHT, TIMES = 0.009, -0.75


def _scene():
    return beam_in_two_poses(LAYERS)[0]


def _seen():
    return beam_in_two_poses(LAYERS)[1]


def _settled(parts, seen):
    stated = {'depth_bias_by_region': part_settings(parts)}
    evaluator, nominal = fit_nominal(replace(_scene(), effects=stated), seen, None)
    return settled_parts(evaluator, nominal, parts)


def test_parts_that_were_misplaced_come_where_they_are_and_are_as_high_as_they_are():
    seen = [with_part(own, TRUE[0], HEIGHT, _scene()) for own in _seen()]
    seen = [with_part(own, TRUE[1], TIMES * HEIGHT, _scene()) for own in seen]
    begun = [SurfacePart(0.67, 1.0, WHOLE), SurfacePart(0.33, 0.67, WHOLE, times=-1.0)]
    outer, inner = _settled(begun, seen)
    assert (outer.begin, outer.end, outer.times) == (pytest.approx(0.7, abs=0.015), 1.0, 1.0)
    assert (inner.begin, inner.end) == pytest.approx((0.3, 0.7), abs=0.015)
    assert inner.times == pytest.approx(TIMES, abs=0.03)


@pytest.mark.slow
def test_parts_of_no_height_stay_as_they_are():
    stated = {'at': 0.6, 'a_until': 0.5}
    (part,) = parts_of(stated)
    (found,) = _settled([part], _seen())
    assert found is part
