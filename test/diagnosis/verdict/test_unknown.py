# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When what is left is so much that no effect of the library can be it."""

from types import SimpleNamespace

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.chi_square import chance_beyond
from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.verdict import field_witness
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.frame_test import ClassScore
from diffcal_ros.diagnosis.verdict.unknown import describe_unknown, is_unexplained
import numpy as np
import pytest

_PATCHES, _PARAMETERS = 200, 8
_MARGIN = 0.0005  # [m]


def fit(chi_square_per_patch, rms=0.0002):
    """Make what a verdict reads of a fit; the floor of every patch is 0.2 mm."""
    count = 40
    patches = Patches(
        values=np.full(count, rms),
        jacobian=np.zeros((count, 0)),
        covariance=0.0002**2 * np.eye(count),
        centers=np.zeros((count, 2)),
        cells=np.arange(count),
        weights=np.ones(count),
        common=CommonError(np.zeros(count), 1.0),
    )
    group = SimpleNamespace(
        is_rigid=False,
        view=0,
        patches=patches,
        mesh=np.zeros(count),
        is_report=np.ones(count, dtype=bool),
    )
    return SimpleNamespace(
        chi_square=chi_square_per_patch * (_PATCHES - _PARAMETERS),
        chi_square_per_patch=chi_square_per_patch,
        patch_count=_PATCHES,
        coordinates=np.zeros(_PARAMETERS),
        parameters=ParameterSet(),
        groups=[group],
    )


def model(chi_square_per_patch, rms=0.0002, left=None, in_its_form=None):
    """Make what a verdict reads of a model with effects."""
    own = fit(chi_square_per_patch, rms)
    exact = in_its_form or chi_square_per_patch
    own.chance_of_noise = chance_beyond(exact * (_PATCHES - _PARAMETERS), _PATCHES - _PARAMETERS)
    return SimpleNamespace(
        fit=own,
        judged=None if left is None else SimpleNamespace(left=left, fraction=0.3),
        chi_square_per_patch=own.chi_square_per_patch,
        chance_of_noise=chance_beyond(own.chi_square, _PATCHES - _PARAMETERS),
    )


@pytest.mark.parametrize(
    ('nominal', 'added', 'rms', 'expected'),
    [
        (30.0, 0.9, 0.0002, False),  # Noise is left.
        (30.0, 1.2, 0.0002, False),  # As noise may look in one of thirty cases.
        (2.8, 1.9, 0.0002, True),  # Half of the excess is left.
        (1.5, 1.4, 0.0002, True),
        (30.0, 3.5, 0.0002, False),  # Nearly closed: details of the model.
        (30.0, 3.5, 0.0006, True),  # The same, and far above the floor.
    ],
)
def test_what_is_left_must_look_like_noise(nominal, added, rms, expected):
    found = is_unexplained(fit(nominal), model(added, rms), 1.0, _MARGIN, is_measured=True)
    assert found is expected


@pytest.mark.parametrize(
    ('closure', 'rms', 'expected'),
    [
        (0.6, 0.0005, True),  # Held-out patches are off.
        (0.6, 0.0002, False),  # There was little to close.
        (0.75, 0.0005, False),
    ],
)
def test_what_was_held_out_must_be_explained_as_well(closure, rms, expected):
    found = is_unexplained(fit(30.0), model(0.9, rms), closure, _MARGIN, is_measured=True)
    assert found is expected


@pytest.mark.parametrize(
    ('before', 'after', 'closure', 'expected'),
    [
        (0.0008, 0.0002, 1.0, False),
        (0.0008, 0.00025, 0.9, True),  # Not all of it.
        (0.0003, 0.0002, 1.0, True),  # There was hardly a gap that could close.
        (0.0008, 0.0002, 0.6, True),  # What strains a parameter is still off.
    ],
)
def test_a_clear_gap_that_is_gone_where_no_fit_has_seen_it_is_explained(
    before, after, closure, expected
):
    """On the patches that were fitted more than half of the excess is left."""
    nominal, added = fit(5.3, before), model(3.3, after)
    assert is_unexplained(nominal, added, closure, _MARGIN, is_measured=True) is expected


@pytest.mark.parametrize(('left', 'expected'), [(0.0002, False), (0.0005, True)])
def test_what_the_form_of_an_effect_may_do_is_explained(left, expected):
    added = model(3.5, 0.0006, left)
    assert is_unexplained(fit(30.0), added, 1.0, _MARGIN, is_measured=True) is expected


@pytest.mark.parametrize(
    ('rms', 'left', 'in_its_form', 'expected'),
    [
        (0.0006, None, 9.0, True),
        (0.0005, None, 9.0, False),  # Above the floor by less than matters.
        (0.0006, 0.0005, 9.0, False),  # In another form.
        (0.0035, 0.0006, 9.0, True),
        (0.0035, 0.0006, 0.9, False),  # Few patches that are known badly.
    ],
)
def test_a_name_beside_which_something_that_matters_is_missing_is_none(
    rms, left, in_its_form, expected
):
    """Forms explain all that was fitted; where no fit has seen it the gap is there."""
    added = model(0.9, rms, left, in_its_form)
    assert is_unexplained(fit(90.0), added, 0.75, _MARGIN, is_measured=True) is expected


def test_what_is_hardly_above_the_floors_is_not_missing_however_little_matters():
    found = is_unexplained(
        fit(30.0), model(0.9, 0.0003, in_its_form=9.0), 0.9, 1e-5, is_measured=True
    )
    assert not found


@pytest.mark.parametrize(('closure', 'expected'), [(0.9, False), (0.5, True), (np.nan, True)])
def test_only_closure_counts_where_the_floor_is_a_guess(closure, expected):
    found = is_unexplained(fit(30.0), model(20.0), closure, _MARGIN, is_measured=False)
    assert found is expected


def test_one_view_has_the_class_of_the_effect_that_comes_nearest(screened):
    evaluator, nominal, _ = screened
    found = describe_unknown(FieldWitness(evaluator, nominal), 'material')
    assert found.groups == ('material',)
    assert found.stand_in is None
    assert found.sentence.endswith('class material')


@pytest.mark.parametrize(
    ('closes', 'is_sure', 'expected'),
    [
        (0.55, False, ('sensor', 'shape')),
        (0.45, False, ('shape', 'sensor')),
        (np.nan, False, ('shape', 'sensor')),
        (0.1, True, ('sensor',)),
    ],
)
def test_the_class_is_that_of_what_closes_more_where_no_fit_has_seen_it(
    screened, monkeypatch, closes, is_sure, expected
):
    evaluator, nominal, _ = screened
    tested = (ClassScore('shape', 90.0, 1.0, 0.5), ClassScore('sensor', 80.0, 1.0, 0.2))
    monkeypatch.setattr(field_witness, 'frame_test', lambda *_: tested)
    witness = FieldWitness(evaluator, nominal)
    found = describe_unknown(witness, 'sensor', is_sure=is_sure, closes=closes)
    assert found.groups == expected
    assert found.stand_in is not None
    assert found.stand_in.group == expected[0]
    assert ' or '.join(expected) in found.sentence


@pytest.mark.parametrize(('of_fields', 'expected'), [(0.2, 'sensor'), (0.3, 'shape')])
def test_fields_that_close_hardly_anything_come_second(screened, monkeypatch, of_fields, expected):
    """They predict poses best, and what came nearest closes nothing as it is or is free."""
    evaluator, nominal, _ = screened
    tested = (ClassScore('shape', 90.0, 1.0, of_fields), ClassScore('sensor', 80.0, 1.0, 0.1))
    monkeypatch.setattr(field_witness, 'frame_test', lambda *_: tested)
    witness = FieldWitness(evaluator, nominal)
    for closes in (np.nan, -0.1):
        found = describe_unknown(witness, 'sensor', closes=closes)
        assert set(found.groups) == {'sensor', 'shape'}
        assert found.groups[0] == expected
        assert found.stand_in is not None
        assert found.stand_in.group == expected


def test_two_that_tell_the_same_class_tell_one(screened, monkeypatch):
    evaluator, nominal, _ = screened
    tested = (ClassScore('shape', 90.0, 1.0, 0.5), ClassScore('sensor', 80.0, 1.0, 0.2))
    monkeypatch.setattr(field_witness, 'frame_test', lambda *_: tested)
    witness = FieldWitness(evaluator, nominal)
    assert describe_unknown(witness, 'shape', closes=0.4).groups == ('shape',)
