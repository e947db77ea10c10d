# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A gap for which every refit came to nothing is called unknown, and never left without a word."""

from dataclasses import replace
import math

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import measure_disagreement
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.selection import select, Selection
from diffcal_ros.diagnosis.screening.shortlist import shortlist, starts_of, with_tangents
from diffcal_ros.diagnosis.verdict import verdict_figures
from diffcal_ros.diagnosis.verdict.conclude import conclude
from diffcal_ros.report.tables.verdict_text import verdict_lines
import pytest


def test_without_any_hypothesis_the_effect_is_unknown(clearly_screened):
    evaluator, fit, scores = clearly_screened
    disagreement = replace(
        measure_disagreement(fit, scores, margin=1e-5), verdict=Verdict.DISAGREE
    )
    diagnosis = conclude(evaluator, fit, scores, disagreement, Selection(()), None, 1.0)
    assert diagnosis.effects == ()
    # Of a single pose the class of the effect with the best score stands.
    best = max(with_tangents(scores).scores, key=lambda score: score.log_evidence)
    assert diagnosis.unknown_class == best.candidate.effect.group
    assert any('unknown effect' in line for line in verdict_lines(diagnosis))
    # What is missing may have drawn the modulus by any amount.
    assert math.isnan(diagnosis.parameters['after']['youngs_modulus']['std_error'])
    assert diagnosis.parameters['before']['youngs_modulus']['std_error'] > 0.0


def test_below_the_margin_nothing_need_be_said(clearly_screened):
    evaluator, fit, scores = clearly_screened
    disagreement = replace(
        measure_disagreement(fit, scores, margin=1e-5), verdict=Verdict.BELOW_MARGIN
    )
    diagnosis = conclude(evaluator, fit, scores, disagreement, Selection(()), None, 1.0)
    assert diagnosis.unknown_class is None


def test_a_name_is_for_what_matters(clearly_screened):
    """The same model, the same confidence: above the margin a name, below it what is nearest."""
    evaluator, fit, scores = clearly_screened
    right = next(s for s in scores.scores if s.candidate.identifier == 'gravity_tilt')
    tried = try_effects(evaluator, fit, [right.candidate], starts_of(right))
    choice = Choice(tried, dict.fromkeys(tried.identifiers, 1.0), tried.identifiers, None)
    judged = measure_disagreement(fit, scores, margin=1e-5)
    large, small = (
        conclude(
            evaluator,
            fit,
            scores,
            replace(judged, verdict=verdict),
            Selection((tried,)),
            choice,
            1.0,
        )
        for verdict in (Verdict.DISAGREE, Verdict.BELOW_MARGIN)
    )
    assert [own.identifier for own in large.effects] == ['gravity_tilt']
    assert small.effects == ()
    assert small.ambiguity_set == ('gravity_tilt',)
    assert small.unknown_class is None
    lines = verdict_lines(small)
    assert 'NEAREST   gravity_tilt' in lines
    assert any('nearest comes gravity_tilt: it closes' in line for line in lines)
    followed = [
        any('may have followed it' in note for note in own.notes) for own in (small, large)
    ]
    assert followed == [True, False]
    # What has the name of a tilt may be a push, and that adds to the weight.
    assert any('may add to the weight' in note for note in large.notes)
    modulus = large.parameters['after']['youngs_modulus']
    assert modulus['std_error'] > verdict_figures.weight_doubt(tried) * modulus['value'] > 0.0


def test_what_comes_nearest_to_an_unknown_effect_is_told(clearly_screened):
    evaluator, fit, scores = clearly_screened
    disagreement = replace(
        measure_disagreement(fit, scores, margin=1e-5), verdict=Verdict.DISAGREE
    )
    # The body is tilted, which no reading of the camera explains.
    wrong = next(s for s in scores.scores if s.candidate.identifier == 'depth_affine')
    tried = try_effects(evaluator, fit, [wrong.candidate], starts_of(wrong))
    choice = Choice(
        tried, dict.fromkeys(tried.identifiers, 0.5), (*tried.identifiers, 'camera_offset'), None
    )
    diagnosis = conclude(evaluator, fit, scores, disagreement, Selection(()), choice, 1.0)
    assert diagnosis.unknown_class is not None
    share = f'{max(diagnosis.closure, 0.0):.0%}'
    (told,) = [line for line in verdict_lines(diagnosis) if 'nearest comes' in line]
    assert f'depth_affine: it closes {share} of the gap' in told
    assert told.endswith('about as near: camera_offset')


@pytest.fixture
def loud_plane(clearly_screened):
    """Scores in which the forces that stand in for a plane explain far more than all else."""
    evaluator, fit, scores = clearly_screened
    louder = tuple(
        replace(s, gain=1e6, log_evidence=1e6) if s.candidate.identifier == 'contact_plane' else s
        for s in scores.scores
    )
    ordered = sorted(louder, key=lambda score: -score.log_evidence)
    return evaluator, fit, replace(scores, scores=tuple(ordered))


@pytest.mark.slow
def test_a_plane_that_touches_nowhere_keeps_nobody_out(loud_plane, monkeypatch):
    evaluator, fit, scores = loud_plane
    first = {score.candidate.identifier for score in shortlist(scores, is_measured=True)}
    assert first == {'contact_plane'}
    assert 'gravity_tilt' in {
        score.candidate.identifier for score in shortlist(with_tangents(scores), is_measured=True)
    }
    monkeypatch.setattr(
        Hypothesis,
        'has_idle_effect',
        property(lambda self: self.identifiers == ('contact_plane',)),
    )
    selection = select(RefitPool(evaluator, fit), scores)
    assert 'gravity_tilt' in {name for h in selection.singles for name in h.identifiers}
