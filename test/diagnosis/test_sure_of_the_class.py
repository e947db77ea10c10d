# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a verdict says beside a name: what else looks like it, and a class that is sure."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import measure_disagreement
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.screening.shortlist import starts_of
from diffcal_ros.diagnosis.verdict import notes
from diffcal_ros.diagnosis.verdict.conclude import conclude
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis
from diffcal_ros.diagnosis.verdict.verdict_figures import named_effects
from diffcal_ros.effects.rigid import ROLLED
import pytest


@pytest.fixture(scope='module')
def tilted(clearly_screened) -> Hypothesis:
    evaluator, fit, scores = clearly_screened
    score = next(s for s in scores.scores if s.candidate.identifier == 'gravity_tilt')
    return try_effects(evaluator, fit, [score.candidate], starts_of(score))


def _concluded(clearly_screened, tilted: Hypothesis, confidence: float, *alike: str) -> Diagnosis:
    evaluator, fit, scores = clearly_screened
    found = measure_disagreement(fit, scores, margin=1e-5)
    disagreement = replace(found, verdict=Verdict.DISAGREE)
    choice = Choice(tilted, dict.fromkeys(tilted.identifiers, confidence), alike, None)
    return conclude(evaluator, fit, scores, disagreement, Selection((tilted,)), choice, 1.0)


def test_a_tilt_is_said_to_be_imitated_by_a_steady_push(clearly_screened, tilted):
    diagnosis = _concluded(clearly_screened, tilted, 0.95, 'gravity_tilt')
    assert [effect.identifier for effect in diagnosis.effects] == ['gravity_tilt']
    (told,) = [note for note in diagnosis.notes if 'steady push' in note]
    assert ROLLED in told
    assert ROLLED in diagnosis.separating_recording
    (entry,) = diagnosis.as_dict()['effects']
    assert entry['outside_twins'] == ['a steady push to the side']


@pytest.mark.parametrize(
    ('other', 'group'), [('added_mass', 'load'), ('camera_offset', None), (None, None)]
)
def test_a_class_is_told_where_the_name_is_not_sure(clearly_screened, tilted, other, group):
    alike = ('gravity_tilt',) if other is None else ('gravity_tilt', other)
    diagnosis = _concluded(clearly_screened, tilted, 0.5, *alike)
    assert diagnosis.effects == ()
    told = [note for note in diagnosis.notes if note.startswith('whichever of them')]
    expected = f'whichever of them it is, it is of the class {group}'
    assert told == ([] if group is None else [expected])


def test_what_is_beside_a_sure_name_is_told(clearly_screened):
    evaluator, fit, scores = clearly_screened
    added = [
        next(s.candidate for s in scores.scores if s.candidate.identifier == name)
        for name in ('clamp_offset', 'rest_curvature')
    ]
    two = try_effects(evaluator, fit, added, {}, max_iterations=1)
    alike = ('clamp_offset', 'rest_curvature', 'camera_offset')
    choice = Choice(two, {'clamp_offset': 0.5, 'rest_curvature': 0.98}, alike, None)
    sure = named_effects(two, {'rest_curvature': 0.98})
    (told,) = notes._beside(choice, sure)
    assert told.startswith('rest_curvature is not all that is missing: beside it is one of ')
    assert 'clamp_offset, camera_offset' in told
    assert notes._beside(choice, ()) == []
    assert notes._beside(choice, named_effects(two, choice.confidences)) == []
    assert notes._beside(None, sure) == []
