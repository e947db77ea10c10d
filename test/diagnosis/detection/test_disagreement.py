# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a gap may come of: a model, or a sensor and poses that are misstated."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import (
    beside_a_model,
    Disagreement,
    measure_disagreement,
)
from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.verdict.conclude import conclude
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
    found = Disagreement(verdict, 1e-9, gap, float(np.sqrt(off**2 - _FLOOR**2)), _MARGIN)
    return found, beside_a_model(found, SimpleNamespace(groups=patches(left)))


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
    closes = float(np.sqrt(0.00056**2 - left**2))
    expected = closes if verdict is Verdict.DISAGREE else found.excess
    assert told.excess == pytest.approx(expected)


@pytest.mark.parametrize(('off', 'may_matter'), [(0.00056, True), (0.00049, False)])
def test_what_is_smaller_than_the_margin_matters_beside_no_model(off, may_matter):
    found, told = judged(off, 0.0)
    assert found.verdict is Verdict.BELOW_MARGIN
    assert found.may_matter == may_matter
    assert (told.verdict is Verdict.DISAGREE) == may_matter


@pytest.mark.parametrize('verdict', [Verdict.AGREE, Verdict.CANNOT_TELL, Verdict.DISAGREE])
def test_what_is_no_gap_without_a_model_is_none_beside_one(verdict):
    found, told = judged(0.00056, 0.0001, verdict)
    assert told is found


@pytest.mark.parametrize(
    ('times', 'verdict'),
    [
        (1.0, Verdict.AGREE),
        # Errors that are twice as large make chi-square four times that.
        (3.0, Verdict.CANNOT_TELL),
        (8.0, Verdict.DISAGREE),
    ],
)
def test_what_misstated_errors_may_be_is_no_disagreement(clearly_screened, times, verdict):
    _, fit, screen = clearly_screened
    quiet = replace(screen, scores=tuple(replace(s, plain_gain=0.0) for s in screen.scores))
    freedom = fit.patch_count - len(fit.coordinates)
    off = replace(fit, chi_square=times * freedom)
    found = measure_disagreement(off, quiet, margin=0.001)
    assert found.verdict is verdict
    assert found.may_be_misstated == (verdict is Verdict.CANNOT_TELL)
    # What does not matter is said to be there, whatever errors are.
    small = measure_disagreement(off, quiet, margin=found.excess)
    assert small.verdict is (Verdict.AGREE if times == 1.0 else Verdict.BELOW_MARGIN)


def test_what_may_be_misstated_is_told(clearly_screened):
    evaluator, fit, screen = clearly_screened
    quiet = replace(screen, scores=tuple(replace(s, plain_gain=0.0) for s in screen.scores))
    off = replace(fit, chi_square=3.0 * (fit.patch_count - len(fit.coordinates)))
    found = measure_disagreement(off, quiet, margin=0.001)
    of_a_fine_mesh = replace(found, gap=replace(found.gap, mesh=0.0))
    diagnosis = conclude(evaluator, off, quiet, of_a_fine_mesh, None, None, 1.0)
    assert any('not from twice these' in note for note in diagnosis.notes), diagnosis.notes
    # Parameters are known as badly as that, too.
    as_stated = replace(of_a_fine_mesh, may_be_misstated=False)
    stated = conclude(evaluator, off, quiet, as_stated, None, None, 1.0)
    for when in ('before', 'after'):
        here, there = (one.parameters[when]['youngs_modulus'] for one in (diagnosis, stated))
        assert here['value'] == there['value']
        assert here['std_error'] == pytest.approx(2.0 * there['std_error'])
        assert there['std_error'] > 0.0


@pytest.mark.parametrize(
    ('share', 'words'), [(0.9, 'more than the'), (1.1, 'the data are too few')]
)
def test_why_data_cannot_tell_is_told(clearly_screened, share, words):
    evaluator, fit, screen = clearly_screened
    found = measure_disagreement(fit, screen, margin=0.0005)
    gap = replace(found.gap, mesh=0.0)
    unsure = replace(found, verdict=Verdict.CANNOT_TELL, gap=gap, margin=share * gap.whole_floor)
    diagnosis = conclude(evaluator, fit, screen, unsure, None, None, 1.0)
    assert any(words in note for note in diagnosis.notes), diagnosis.notes


def test_a_motion_is_judged_by_what_is_stated(clearly_screened):
    _, fit, screen = clearly_screened
    quiet = replace(screen, scores=tuple(replace(s, plain_gain=0.0) for s in screen.scores))
    off = replace(fit, chi_square=3.0 * (fit.patch_count - len(fit.coordinates)))
    found = measure_disagreement(off, quiet, margin=1e-5, is_moving=True)
    assert found.verdict is Verdict.DISAGREE


@pytest.mark.parametrize(
    ('mesh', 'is_measured', 'times', 'verdict'),
    [
        (0.0, True, 100.0, Verdict.DISAGREE),
        # By errors that are twice as large it may be noise.
        (0.0, True, 3.0, Verdict.CANNOT_TELL),
        # A guess, and a mesh, want three times what they may be off by.
        (0.0, False, 100.0, Verdict.CANNOT_TELL),
        (0.9, True, 100.0, Verdict.CANNOT_TELL),
    ],
)
def test_a_measured_sensor_that_is_noisier_than_the_margin_tells_what_stands_out(
    clearly_screened, mesh, is_measured, times, verdict
):
    _, fit, screen = clearly_screened
    quiet = replace(screen, scores=tuple(replace(s, plain_gain=0.0) for s in screen.scores))
    groups = [
        replace(
            group,
            # A gap of twice the floor: above any margin that the floor hides.
            patches=replace(p, values=np.sign(p.values) * 2.0 * np.sqrt(p.variances)),
            mesh=mesh * np.sqrt(p.variances),
        )
        for group in fit.groups
        for p in (group.patches,)
    ]
    off = replace(fit, groups=groups, chi_square=times * (fit.patch_count - len(fit.coordinates)))
    floor = patch_gap(groups, Part.ALL).floor
    found = measure_disagreement(off, quiet, margin=0.9 * floor, is_measured=is_measured)
    assert found.gap.whole_floor > found.margin
    assert found.excess > found.margin
    assert found.verdict is verdict
