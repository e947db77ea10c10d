# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An effect that is there may be as large as it is."""

from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.motion_refit import with_own_size
from diffcal_ros.diagnosis.screening.candidates import candidates
import pytest


@pytest.mark.parametrize('times', [0.5, -5.0])
def test_an_amplitude_that_is_there_is_as_large_as_it_is(too_far, times):
    evaluator, fit = too_far
    listed = candidates(evaluator.model.scene)
    mass = next(c for c in listed if c.identifier == 'added_mass')
    _, tried = with_effects(evaluator, fit, [mass])
    before = tried.model.parameters
    index = before.names.index('added_mass.mass')
    usual = before.parameters[index].quantity.prior_std
    coordinates = before.start()
    coordinates[index] = times * usual
    after = with_own_size(before, coordinates, {'added_mass.mass'})
    assert after.parameters[index].quantity.prior_std == pytest.approx(max(1.0, -times) * usual)
    assert after.parameters[index].quantity.prior_mean == 0.0
    others = [n for n in range(len(before)) if n != index]
    assert [after.parameters[n] for n in others] == [before.parameters[n] for n in others]
