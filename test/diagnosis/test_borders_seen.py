# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where materials end shows beside what else is missing, where that hides it from the model."""

from dataclasses import replace

from diffcal_ros.diagnosis.borders_seen import with_borders_seen_beside, with_none_seen
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.errors import NotSimulatedError
import numpy as np
import pytest
from support.clamped_anew import beam_in_two_poses, lifted
from support.watched import with_part

AT, HEIGHT = 0.35, -0.003
# The body is clamped by so much above where the scene says, in each pose [m].
LIFTS = (0.010, 0.006)


def _scene(lifts):
    return lifted(beam_in_two_poses(16)[0], lifts)


def _beside_a_clamp(scene, seen):
    """Return the nominal evaluator and fit, and a model of a body that is clamped elsewhere."""
    evaluator, nominal = fit_nominal(scene, seen, None)
    offsets = [c for c in candidates(scene) if c.identifier == 'clamp_offset']
    fullest = max(offsets, key=lambda own: len(own.components))
    return evaluator, nominal, try_effects(evaluator, nominal, [fullest], {})


@pytest.fixture(scope='module')
def hidden():
    """Return those of a body of which a step is read too near, and lifted in its clamp."""
    plain, seen = beam_in_two_poses(16)
    stepped = [with_part(own, {'at': AT}, HEIGHT, plain) for own in seen]
    return _beside_a_clamp(_scene(LIFTS), stepped)


def _borders(found):
    evaluator, _ = found
    return {name: own['at'] for name, own in evaluator.model.scene.effects.items()}


def test_a_step_that_a_displaced_body_hides_shows_beside_that(hidden):
    evaluator, nominal, clamped = hidden
    assert not evaluator.model.scene.effects
    borders = _borders(with_borders_seen_beside([clamped], evaluator, nominal))
    assert borders.keys() == {'depth_bias_by_region', 'stiffness_contrast'}
    assert borders['depth_bias_by_region'] == pytest.approx(AT, abs=0.02)


@pytest.mark.slow
def test_beside_a_displaced_body_alone_nothing_shows():
    evaluator, nominal, clamped = _beside_a_clamp(_scene(LIFTS), beam_in_two_poses(16)[1])
    assert with_borders_seen_beside([clamped], evaluator, nominal) is None


@pytest.mark.slow
def test_where_borders_are_known_none_are_looked_for(hidden):
    evaluator, nominal, clamped = hidden
    known = with_borders_seen_beside([clamped], evaluator, nominal)
    assert with_borders_seen_beside([clamped], *known) is None


@pytest.mark.slow
def test_beside_a_model_that_finds_no_rest_nothing_is_looked_for(hidden):
    """It was reached step by step, and may not be from where it is unloaded."""
    evaluator, nominal, clamped = hidden
    names = clamped.fit.parameters.names
    soft = clamped.fit.coordinates.copy()
    soft[names.index('youngs_modulus')] -= np.log(1e9)
    lost = replace(clamped, fit=replace(clamped.fit, coordinates=soft))
    with pytest.raises(NotSimulatedError):
        lost.evaluator.model.views(soft)
    found = with_borders_seen_beside([lost, clamped], evaluator, nominal)
    assert _borders(found) == _borders(with_borders_seen_beside([clamped], evaluator, nominal))


def test_beside_a_model_whose_body_is_out_of_sight_nothing_is_looked_for(hidden):
    """What was fitted there is not what is found again from rest."""
    evaluator, nominal, clamped = hidden
    names = clamped.fit.parameters.names
    away = clamped.fit.coordinates.copy()
    away[names.index('clamp_offset.y')] += 1.0
    lost = replace(clamped, fit=replace(clamped.fit, coordinates=away))
    assert with_borders_seen_beside([lost], evaluator, nominal) is None


@pytest.mark.slow
def test_what_pixels_showed_is_looked_for_anew_and_what_was_stated_is_not(hidden):
    evaluator, nominal, clamped = hidden
    known = with_borders_seen_beside([clamped], evaluator, nominal)
    forgotten = with_none_seen(evaluator.model.scene, *known)
    assert not forgotten[0].model.scene.effects
    np.testing.assert_array_equal(forgotten[1].coordinates, nominal.coordinates)
    again = with_borders_seen_beside([clamped], *forgotten)
    assert _borders(again) == _borders(known)
    stated = known[0].model.scene
    assert with_none_seen(stated, *known) == known
    assert with_none_seen(evaluator.model.scene, evaluator, nominal) == (evaluator, nominal)
