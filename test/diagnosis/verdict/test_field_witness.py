# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two witnesses who know nothing of one another give a form that is far off its name."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import measure_disagreement
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.verdict import doubts
from diffcal_ros.diagnosis.verdict.conclude import conclude
from diffcal_ros.diagnosis.verdict.doubts import doubts_about
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
import pytest
from support.judged_models import refitted_with, with_judgement, witness_of


@pytest.fixture(scope='module')
def far_off(clearly_screened) -> Hypothesis:
    """A tilt that closes the gap, in a form that is off by most of what it does."""
    return with_judgement(refitted_with(clearly_screened, 'gravity_tilt'), fraction=0.8)


@pytest.mark.parametrize(
    ('predictions', 'expected'),
    [
        pytest.param({'load': 60.0, 'shape': 40.0}, True, id='its class, clearly'),
        pytest.param({'load': 60.0, 'shape': 58.0}, False, id='about as well'),
        pytest.param({'load': 40.0, 'shape': 60.0}, False, id='another class'),
        pytest.param({}, False, id='no class'),
    ],
)
def test_fields_speak_for_their_class(clearly_screened, far_off, predictions, expected):
    assert witness_of(clearly_screened, **predictions).speaks_for(far_off) is expected


def test_fields_speak_for_two_effects_if_for_one(clearly_screened, far_off):
    two = replace(far_off, added=(*far_off.added, Candidate('depth_affine', ('bias',))))
    assert witness_of(clearly_screened, sensor=60.0, shape=40.0).speaks_for(two)
    assert not witness_of(clearly_screened, shape=60.0, sensor=40.0).speaks_for(two)


def test_one_view_speaks_for_nothing(screened, far_off):
    evaluator, nominal, _ = screened
    witness = FieldWitness(evaluator, nominal)
    assert witness.scores == ()
    assert not witness.speaks_for(far_off)


def test_what_both_witnesses_speak_for_has_its_name(clearly_screened, far_off):
    _, nominal, _ = clearly_screened
    own = witness_of(clearly_screened, load=60.0, shape=40.0)
    other = witness_of(clearly_screened, load=40.0, shape=60.0)
    assert doubts_about(far_off, nominal, (), own) == ()
    for nobody in (other, None):
        (doubt,) = doubts_about(far_off, nominal, (), nobody)
        assert 'off by 80%' in doubt


@pytest.mark.parametrize(('moved', 'is_named'), [(3e-4, True), (6e-4, False)])
def test_a_gap_that_stays_where_no_fit_has_seen_it_speaks_against(
    clearly_screened, far_off, moved, is_named
):
    """Closed by 95 % it has its name, and by 93 % none."""
    _, nominal, _ = clearly_screened
    groups = [
        replace(one, patches=replace(one.patches, values=one.patches.values + moved))
        for one in far_off.fit.groups
    ]
    left = replace(far_off, fit=replace(far_off.fit, groups=groups))
    own = witness_of(clearly_screened, load=60.0, shape=40.0)
    assert (doubts_about(left, nominal, (), own) == ()) is is_named


@pytest.mark.parametrize(
    ('count', 'fraction', 'is_anything', 'is_named'),
    [
        pytest.param(1, 0.8, True, True, id='one'),
        pytest.param(2, 0.2, False, True, id='two, not far off'),
        pytest.param(2, 0.3, False, False, id='two, far off'),
        pytest.param(2, 0.2, True, False, id='two, in each pose as well'),
    ],
)
def test_of_two_effects_fields_speak_for_one(
    clearly_screened, far_off, monkeypatch, count, fraction, is_anything, is_named
):
    _, nominal, _ = clearly_screened
    monkeypatch.setattr(Hypothesis, 'is_free_in_everything', is_anything)
    monkeypatch.setattr(doubts, '_differs_by_pose', lambda _: None)
    # Of a free form: without a witness an eighth is what a pair may be off by.
    monkeypatch.setattr(doubts, '_farthest_form', lambda _: 0.125)
    model = replace(with_judgement(far_off, fraction=fraction), added=far_off.added * count)
    own = witness_of(clearly_screened, load=60.0, shape=40.0)
    assert doubts_about(model, nominal)
    assert (doubts_about(model, nominal, (), own) == ()) is is_named


def test_what_is_another_one_in_each_pose_has_a_class_and_no_name(clearly_screened, far_off):
    """Whatever pushes differently in each pose is a load as a tilt is."""
    _, nominal, _ = clearly_screened
    own = witness_of(clearly_screened, load=60.0, shape=40.0)
    other = replace(far_off, judged=replace(far_off.judged, by_pose=0.9))
    (doubt,) = doubts_about(other, nominal, (), own)
    assert 'another one in each pose' in doubt


def test_a_note_says_why_it_has_its_name(clearly_screened, far_off):
    evaluator, nominal, scores = clearly_screened
    disagreement = replace(measure_disagreement(nominal, scores, 5e-4), verdict=Verdict.DISAGREE)
    choice = Choice(far_off, {'gravity_tilt': 0.7}, ('gravity_tilt',), None)
    own = witness_of(clearly_screened, load=60.0, shape=40.0)
    given = (evaluator, nominal, scores, disagreement, None, choice, 1.0)
    diagnosis = conclude(*given, witness=own)
    assert [effect.identifier for effect in diagnosis.effects] == ['gravity_tilt']
    (note,) = (text for text in diagnosis.notes if 'tell the same class' in text)
    assert note.startswith('gravity_tilt is there in a form that is off by 80% of what it does')
    alone = conclude(*given)
    assert alone.effects == ()
    assert alone.unknown_classes
