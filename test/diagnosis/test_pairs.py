# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which second effects are worth a refit."""

from diffcal_ros.diagnosis.model_comparison.hypothesis import try_effects
from diffcal_ros.diagnosis.model_comparison.selection import _worth_adding
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import screen
from diffcal_ros.diagnosis.screening.shortlist import distinct, starts_of
import pytest


@pytest.mark.parametrize(('name', 'is_right'), [('gravity_tilt', True), ('depth_affine', False)])
def test_a_second_effect_is_tried_where_tangents_promise_enough_of_it(screened, name, is_right):
    evaluator, nominal, scores = screened
    score = next(s for s in scores.scores if s.candidate.identifier == name)
    one = try_effects(evaluator, nominal, [score.candidate], starts_of(score))
    others = [c for c in candidates(evaluator.model.scene) if c.identifier != name]
    around = distinct(screen(one.evaluator, one.fit.coordinates, others).scores)
    tried = {s.candidate.identifier for s in _worth_adding(one, around, [one])}
    smooth = {s.candidate.identifier for s in around if s.candidate.effect.has_tangent}
    # Beside the tilt nothing is left; what stands in for a contact promises nothing either way.
    assert tried - smooth == {'contact_plane'}
    assert (tried & smooth == set()) == is_right
    assert ('gravity_tilt' in tried) == (not is_right)
