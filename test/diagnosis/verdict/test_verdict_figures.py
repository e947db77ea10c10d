# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A name is no surer than what else could look like it allows."""

from diffcal_ros.diagnosis.model_comparison.hypothesis import try_effects
from diffcal_ros.diagnosis.verdict.verdict_figures import named_effects
from diffcal_ros.effects.registry import EFFECTS
import pytest

SURE = 0.99


@pytest.mark.parametrize(('name', 'is_imitated'), [('gravity_tilt', True), ('added_mass', False)])
def test_a_name_that_a_cause_outside_the_library_imitates_is_less_sure(
    screened, name, is_imitated
):
    evaluator, fit, scores = screened
    candidate = next(s.candidate for s in scores.scores if s.candidate.identifier == name)
    found = try_effects(evaluator, fit, [candidate], {}, max_iterations=1)
    (effect,) = named_effects(found, SURE)
    assert effect.confidence == (EFFECTS[name].most_confidence if is_imitated else SURE)
    assert (effect.confidence < SURE) == is_imitated
    # What is not sure already does not become less so.
    assert named_effects(found, 0.3)[0].confidence == 0.3
