# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A name whose form is in doubt is as sure as such names have been right."""

from dataclasses import replace

from diffcal_ros.calibration.parameters.form_parameters import form_parameters
from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import measure_disagreement
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.verdict import form_in_doubt, naming
from diffcal_ros.diagnosis.verdict.conclude import conclude
from diffcal_ros.diagnosis.verdict.form_in_doubt import with_form_in_doubt
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.report.tables.verdict_text import verdict_lines
import pytest
from support.freed import with_parts
from support.judged_models import refitted_with, with_judgement, witness_of

# Of one effect, and of two.
SURE, IN_DOUBT, IN_DOUBT_OF_TWO = 0.99, 0.67, 0.59


@pytest.fixture(scope='module')
def tilted(clearly_screened) -> Hypothesis:
    return refitted_with(clearly_screened, 'gravity_tilt')


def _chosen(model: Hypothesis, sure: float = SURE) -> Choice:
    return Choice(model, {'gravity_tilt': sure}, ('gravity_tilt',), None)


@pytest.mark.parametrize(('fraction', 'is_usual'), [(0.05, True), (0.12, True), (0.13, False)])
def test_a_name_in_a_form_in_doubt_is_as_sure_as_such_names_were_right(
    clearly_screened, tilted, fraction, is_usual
):
    _, nominal, _ = clearly_screened
    before = _chosen(with_judgement(tilted, fraction=fraction))
    after = with_form_in_doubt(before, nominal)
    assert (after is before) == is_usual
    assert after.confidences == {'gravity_tilt': SURE if is_usual else IN_DOUBT}
    assert is_usual or 'may be off by 13% of what it does' in after.unsure
    little = with_form_in_doubt(_chosen(before.hypothesis, 0.2), nominal)
    assert little.confidences == {'gravity_tilt': 0.2}, 'what is not sure is no surer by that'


def test_a_form_that_was_not_asked_for_takes_no_confidence(clearly_screened, tilted):
    """Motions and single frames are judged as they are."""
    _, nominal, _ = clearly_screened
    choice = _chosen(tilted)
    assert tilted.judged is None
    assert with_form_in_doubt(choice, nominal) is choice


def test_a_form_of_which_data_tell_nothing_is_in_doubt(clearly_screened, tilted):
    """It may leave noise, as any other form would."""
    _, nominal, _ = clearly_screened
    model = with_judgement(tilted, fraction=0.2, exact=tilted.fit.log_evidence)
    quiet = replace(model, fit=replace(tilted.fit, chi_square=0.8 * tilted.fit.patch_count))
    assert (quiet.leaning, quiet.fit.chance_of_noise > 0.05) == (0.0, True)
    assert with_form_in_doubt(_chosen(quiet), nominal).confidence == IN_DOUBT


@pytest.mark.parametrize(('leaning', 'is_sure'), [(0.0, True), (6.0, True), (10.0, False)])
def test_a_form_of_its_own_is_in_doubt_where_data_ask_for_yet_another(
    clearly_screened, tilted, leaning, is_sure
):
    _, nominal, _ = clearly_screened
    exact = tilted.fit.log_evidence - leaning
    model = with_judgement(tilted, fraction=0.2, exact=exact)
    gap = patch_gap(model.fit.groups, Part.REPORT)
    assert gap.rms < 1.7 * gap.whole_floor, 'little is left'
    free = with_parts(model, form_parameters(EFFECTS['rest_curvature'], 0.1))
    assert with_form_in_doubt(_chosen(free), nominal).confidence == (SURE if is_sure else IN_DOUBT)
    assert with_form_in_doubt(_chosen(model), nominal).confidence == IN_DOUBT


@pytest.mark.parametrize(
    ('predictions', 'closure', 'is_sure'),
    [
        ({'load': 60.0, 'shape': 40.0}, 0.96, True),
        ({'load': 60.0, 'shape': 40.0}, 0.9, False),
        ({'load': 40.0, 'shape': 60.0}, 0.96, False),
    ],
)
def test_two_witnesses_speak_for_a_form_in_doubt(
    clearly_screened, tilted, monkeypatch, predictions, closure, is_sure
):
    monkeypatch.setattr(form_in_doubt, 'closed_by', lambda *_: closure)
    _, nominal, _ = clearly_screened
    choice = _chosen(with_judgement(tilted, fraction=0.3))
    found = with_form_in_doubt(choice, nominal, witness_of(clearly_screened, **predictions))
    assert found.confidence == (SURE if is_sure else IN_DOUBT)


def _concluded(screened: tuple, model: Hypothesis, monkeypatch) -> Diagnosis:
    """Return the verdict on a gap that matters, where a model was chosen and not doubted."""
    monkeypatch.setattr(naming, 'doubts_about', lambda *_: ())
    monkeypatch.setattr(naming, 'is_unexplained', lambda *_, **__: False)
    evaluator, nominal, scores = screened
    disagreement = replace(measure_disagreement(nominal, scores, 5e-4), verdict=Verdict.DISAGREE)
    choice = with_form_in_doubt(_chosen(model), nominal)
    return conclude(evaluator, nominal, scores, disagreement, None, choice, 1.0)


def _names(found: Diagnosis) -> list[str]:
    listed = [line.split(maxsplit=1) for line in verdict_lines(found)]
    return [words for head, words in listed if head == 'NAME']


def test_two_effects_in_doubt_are_less_sure_than_one(clearly_screened):
    """Of two at once fewer were right, and none has its name."""
    _, nominal, _ = clearly_screened
    both = refitted_with(clearly_screened, 'gravity_tilt', 'added_mass')
    sure = dict.fromkeys(both.identifiers, SURE)
    choice = Choice(with_judgement(both, fraction=0.2), sure, both.identifiers, None)
    found = with_form_in_doubt(choice, nominal).confidences
    assert found == dict.fromkeys(both.identifiers, IN_DOUBT_OF_TWO)
    assert IN_DOUBT_OF_TWO < naming._NAMED < IN_DOUBT


def test_what_is_of_a_form_in_doubt_has_its_name_and_why_it_is_no_surer(
    clearly_screened, tilted, monkeypatch
):
    found = _concluded(clearly_screened, with_judgement(tilted, fraction=0.3), monkeypatch)
    (effect,) = found.effects
    assert (effect.identifier, effect.confidence) == ('gravity_tilt', IN_DOUBT)
    assert found.ambiguity_set == ('gravity_tilt',)
    assert found.separating_recording is not None
    (name,) = _names(found)
    assert name.startswith('gravity_tilt a ')
    assert sum('off by 30% of what it does' in note for note in found.notes) == 1


def test_what_is_of_its_form_has_its_name(clearly_screened, tilted, monkeypatch):
    found = _concluded(clearly_screened, with_judgement(tilted, fraction=0.1), monkeypatch)
    (effect,) = found.effects
    assert effect.confidence == tilted.added[0].effect.most_confidence
    (name,) = _names(found)
    assert name.startswith('gravity_tilt a ')
    assert not any('of what it does' in note for note in found.notes)
