# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a model leaves is the most that a sensor can have added."""

from types import SimpleNamespace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import beside_a_model, Disagreement
from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.whitened import Part, patch_gap
import numpy as np
import pytest

_FLOOR, _MARGIN = 0.0003, 0.0005


def patches(size):
    """Twenty patches that are off by so much [m]."""
    own = Patches(
        values=size * np.where(np.arange(20) % 2, 1.0, -1.0),
        jacobian=np.zeros((20, 0)),
        covariance=_FLOOR**2 * np.eye(20),
        centers=np.zeros((20, 2)),
        cells=np.arange(20),
        weights=np.ones(20),
        common=CommonError(np.zeros(20), 1.0),
    )
    return [PatchGroup(0, 'depth', 0, own, np.zeros(20), np.zeros(20, dtype=bool))]


def judged(off, left, verdict=Verdict.BELOW_MARGIN):
    gap = patch_gap(patches(off), Part.ALL)
    found = Disagreement(verdict, 1e-9, gap, float(np.sqrt(off**2 - _FLOOR**2)))
    return found, beside_a_model(found, SimpleNamespace(groups=patches(left)), _MARGIN)


@pytest.mark.parametrize(
    ('left', 'verdict'),
    [
        (0.0001, Verdict.DISAGREE),
        (0.0002, Verdict.DISAGREE),
        # It takes away half a millimetre at most: that does not matter.
        (0.00026, Verdict.BELOW_MARGIN),
        (0.0004, Verdict.BELOW_MARGIN),
    ],
)
def test_a_gap_that_a_model_closes_below_the_floors_may_matter(left, verdict):
    found, told = judged(0.00056, left)
    assert found.excess < _MARGIN
    assert told.verdict is verdict
    if told is not found:
        assert told.excess == pytest.approx(np.sqrt(0.00056**2 - left**2))


@pytest.mark.parametrize('verdict', [Verdict.AGREE, Verdict.CANNOT_TELL, Verdict.DISAGREE])
def test_what_is_no_gap_without_a_model_is_none_beside_one(verdict):
    found, told = judged(0.00056, 0.0001, verdict)
    assert told is found
