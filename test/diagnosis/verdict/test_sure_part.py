# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Of two effects that may not be named together the one that all models have is named."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import measure_disagreement
from diffcal_ros.diagnosis.model_comparison.choice import choose
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.screening.shortlist import starts_of
from diffcal_ros.diagnosis.verdict import sure_part
from diffcal_ros.diagnosis.verdict.conclude import conclude
from diffcal_ros.diagnosis.verdict.doubts import doubts_about
from diffcal_ros.diagnosis.verdict.sure_part import with_sure_part
import pytest
from support.judged_models import with_judgement


def _level(model: Hypothesis, level: float, fraction: float) -> Hypothesis:
    """Return a model with a log evidence and a tolerance of its form that it owes much to."""
    own = with_judgement(model, log_evidence=level, fraction=fraction, exact=level - 80.0)
    return replace(own, fit=replace(own.fit, log_evidence=level))


@pytest.fixture(scope='module')
def models(clearly_screened):
    """A tilt, a bend, and both: refitted."""
    evaluator, nominal, scores = clearly_screened
    found = []
    for names in (('gravity_tilt',), ('rest_curvature',), ('gravity_tilt', 'rest_curvature')):
        own = [next(s for s in scores.scores if s.candidate.identifier == n) for n in names]
        starts = {k: v for s in own for k, v in starts_of(s).items()}
        found.append(try_effects(evaluator, nominal, [s.candidate for s in own], starts))
    return found


def _chosen(clearly_screened, models, *, of_bend=-300.0, of_tilt_form=0.1, of_pair_form=0.8):
    evaluator, nominal, _ = clearly_screened
    tilt, bend, both = models
    selection = Selection(
        singles=(_level(tilt, -100.0, of_tilt_form), _level(bend, of_bend, 0.1)),
        pairs=(_level(both, -40.0, of_pair_form),),
    )
    pair = choose(replace(selection), evaluator, nominal)
    # What is chosen of these is a matter of other rules.
    pair = replace(pair, hypothesis=selection.pairs[0])
    return pair, with_sure_part(pair, selection, nominal), selection


def test_what_all_near_models_have_is_named_without_the_other_one(clearly_screened, models):
    _, nominal, _ = clearly_screened
    pair, sure, selection = _chosen(clearly_screened, models)
    assert doubts_about(pair.hypothesis, nominal, selection.singles)
    assert sure.hypothesis.identifiers == ('gravity_tilt',)
    assert sure.confidences == {'gravity_tilt': 1.0}
    assert sure.beside == 'rest_curvature'


@pytest.mark.parametrize(
    'changes',
    [
        pytest.param({'of_bend': -105.0}, id='without it another one comes near'),
        pytest.param({'of_tilt_form': 0.9}, id='alone it may not be named'),
    ],
)
def test_else_the_choice_stays(clearly_screened, models, changes):
    pair, sure, _ = _chosen(clearly_screened, models, **changes)
    assert sure is pair


def test_where_no_other_single_effect_was_fitted_it_is_held_against_none(clearly_screened, models):
    _, nominal, _ = clearly_screened
    pair, _, selection = _chosen(clearly_screened, models)
    alone = replace(selection, singles=selection.singles[:1])
    assert with_sure_part(pair, alone, nominal).hypothesis.identifiers == ('gravity_tilt',)
    as_good = replace(nominal, log_evidence=-101.0)
    assert with_sure_part(pair, alone, as_good) is pair


def test_two_that_may_be_named_stay_two(clearly_screened, models, monkeypatch):
    _, nominal, _ = clearly_screened
    pair, sure, selection = _chosen(clearly_screened, models)
    assert sure is not pair
    monkeypatch.setattr(sure_part, 'doubts_about', lambda *_: ())
    assert with_sure_part(pair, selection, nominal) is pair


def test_a_note_says_what_came_nearest_beside_it(clearly_screened, models):
    evaluator, nominal, scores = clearly_screened
    _, sure, selection = _chosen(clearly_screened, models)
    disagreement = replace(measure_disagreement(nominal, scores, 5e-4), verdict=Verdict.DISAGREE)
    diagnosis = conclude(evaluator, nominal, scores, disagreement, selection, sure, 1.0)
    assert [effect.identifier for effect in diagnosis.effects] == ['gravity_tilt']
    assert (
        'gravity_tilt is not all that is missing: rest_curvature came nearest beside it, and has '
        'no name'
    ) in diagnosis.notes
