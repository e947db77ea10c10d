# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Diagnosis of a released beam: clean frames agree, late stamps and the air's drag are named."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Evidence, Verdict
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.parameters_in_any_form import in_any_form
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.strain import unstrained
from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import screen
from diffcal_ros.scene.model import Quantity
import numpy as np
import pytest
from support.filmed import (
    filmed,
    filmed_hold,
    filmed_scene,
    held_scene,
    RELEASE,
    SAGGING,
    STIFF,
)
from support.moving_beams import DAMPING
from support.scenes import beam_scene

LATE, AREA, SOFT = 0.006, 0.06, 100e3
_AMPLITUDE = 0.08
# Standard errors within which an amplitude is expected, of a simulation by another mesh and step.
_SURE = 2.5


def test_late_stamps_of_a_small_body_score_best() -> None:
    """The mesh is too coarse for a verdict, and the swing tells all the same."""
    scene = filmed_scene(is_small=True)
    evaluator, nominal = fit_nominal(scene, filmed(seed=1, late=LATE, is_small=True), None)
    best, second, *_ = screen(evaluator, nominal.coordinates, candidates(scene)).scores
    assert best.candidate.identifier == 'time_offset'
    assert best.log_evidence > second.log_evidence + 100.0 > 100.0


_SCATTER = np.array([1, 4, -3, 5, 0, -4, 6, 2, -5, 3, -2, 6, 1, -6])


@pytest.mark.parametrize(
    'late',
    [LATE + 1e-3 * _SCATTER, 0.012 * np.linspace(0.0, 1.0, len(_SCATTER))],
    ids=['they scatter', 'they fall behind more and more'],
)
@pytest.mark.slow
def test_a_form_of_late_stamps_draws_the_modulus_less_where_it_may_be_any(late) -> None:
    """The library's form, all as late, is many standard errors off; frames are of this mesh."""
    scene = filmed_scene(is_small=True)
    evaluator, nominal = fit_nominal(scene, filmed(seed=1, late=late, is_small=True), None)
    offset = next(own for own in candidates(scene) if own.identifier == 'time_offset')
    model = try_effects(evaluator, nominal, [offset], {})
    told = in_any_form(model, nominal)
    index = told.parameters.names.index('youngs_modulus')
    before, after = (abs(fit.coordinates[index] - np.log(STIFF)) for fit in (model.fit, told))
    errors = [float(np.sqrt(fit.covariance[index, index])) for fit in (model.fit, told)]
    assert before > 5.0 * errors[0]
    assert after < 0.4 * before
    assert after < _SURE * errors[1]


@pytest.mark.slow
def test_clean_frames_from_another_mesh_and_step_agree() -> None:
    diagnosis = diagnose(filmed_scene(), filmed(seed=1)).diagnosis
    assert diagnosis.verdict is Verdict.AGREE
    assert diagnosis.effects == ()
    assert diagnosis.evidence is Evidence.CONFIRMED
    assert diagnosis.gap_mm.nominal < 1.5 * diagnosis.gap_mm.floor_sensor
    assert {'time_offset', 'air_drag'} <= set(diagnosis.limits)


@pytest.mark.slow
def test_late_stamps_are_named_and_the_gap_closes() -> None:
    trace = diagnose(filmed_scene(), filmed(seed=1, late=LATE))
    diagnosis = trace.diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'time_offset'
    assert effect.amplitude['late'] == pytest.approx(1e3 * LATE, rel=_AMPLITUDE)
    assert abs(effect.amplitude['late'] - 1e3 * LATE) < _SURE * effect.std_error['late']
    assert effect.unit['late'] == 'ms'
    assert diagnosis.closure > 0.9
    when = diagnosis.when
    assert when is not None
    assert len(when.times) == len(when.rms_mm) == 14
    assert sum(when.held_out) == 3
    # The first frames show the body at rest; stamps do not matter there.
    assert when.rms_mm[0] < 0.5 * max(when.rms_mm)
    assert when.frequency_hz is not None
    assert 1.0 < when.frequency_hz < 15.0
    held_out = [o for o in trace.evaluator.model.observations if o.is_held_out]
    assert len(held_out) == 3
    for group in trace.nominal.groups:
        seen = trace.evaluator.model.observations[group.view]
        assert (group.is_report == seen.is_held_out).all()


@pytest.mark.slow
def test_drag_that_hides_in_the_damping_is_named_and_the_damping_heals() -> None:
    trace = diagnose(filmed_scene(SOFT), filmed(seed=2, area=AREA, modulus=SOFT))
    diagnosis = trace.diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'air_drag'
    assert effect.amplitude['area'] == pytest.approx(1e4 * AREA, rel=_AMPLITUDE)
    assert abs(effect.amplitude['area'] - 1e4 * AREA) < _SURE * effect.std_error['area']
    before, after = (diagnosis.parameters[when]['damping'] for when in ('before', 'after'))
    assert before['value'] > 3.0 * DAMPING
    assert after['value'] == pytest.approx(DAMPING, rel=0.2)
    # The gap alone is small: it is the strain on what is known of the damping that tells.
    plain, strained = trace.nominal.groups, unstrained(trace.nominal)
    assert patch_gap(strained, Part.ALL).rms > 2.0 * patch_gap(plain, Part.ALL).rms


@pytest.mark.slow
def test_creep_is_named_with_its_time_and_a_load_that_is_only_held_agrees() -> None:
    share, tau = 0.3, 4.0
    diagnosis = diagnose(held_scene(), filmed_hold(seed=2, share=share, tau=tau)).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'creep'
    assert effect.amplitude['share'] == pytest.approx(100.0 * share, rel=_AMPLITUDE)
    assert effect.amplitude['tau'] == pytest.approx(tau, rel=0.25)
    plain = diagnose(held_scene(), filmed_hold(seed=3)).diagnosis
    assert plain.verdict is Verdict.AGREE


@pytest.mark.slow
def test_a_clamp_that_gives_way_to_a_load_that_is_held_is_named() -> None:
    frames = filmed_hold(seed=2, compliance=12.0)
    diagnosis = diagnose(held_scene(), frames).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'compliant_clamp'
    assert effect.amplitude['compliance'] == pytest.approx(12.0, rel=_AMPLITUDE)
    assert diagnosis.gap_mm.added < 0.4 * diagnosis.gap_mm.nominal
    before, after = (diagnosis.parameters[when]['youngs_modulus'] for when in ('before', 'after'))
    # Before, the body was softer in place of its clamp.
    assert before['value'] < 0.8 * SAGGING
    assert abs(after['value'] - SAGGING) < _SURE * after['std_error']


@pytest.mark.slow
def test_a_clamp_that_gives_way_to_a_swing_is_named() -> None:
    diagnosis = diagnose(filmed_scene(), filmed(seed=3, compliance=8.0)).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'compliant_clamp'
    assert effect.amplitude['compliance'] == pytest.approx(8.0, rel=2.0 * _AMPLITUDE)
    before, after = (diagnosis.parameters[when]['youngs_modulus'] for when in ('before', 'after'))
    # Before, the body was softer in place of its clamp.
    assert before['value'] < 0.9 * STIFF
    assert abs(after['value'] - STIFF) < _SURE * after['std_error']


def test_effects_are_offered_where_they_can_be_seen() -> None:
    at_rest = {c.identifier for c in candidates(beam_scene())}
    assert not at_rest & {'time_offset', 'air_drag'}
    moving = {c.identifier for c in candidates(filmed_scene())}
    assert moving >= {'time_offset', 'air_drag', 'gravity_tilt', 'added_mass', 'compliant_clamp'}
    assert 'contact_plane' not in moving
    # Steps that go by what acts at their begin do not follow a clamp that gives way.
    assert 'compliant_clamp' not in {c.identifier for c in candidates(stepped_explicitly())}
    # A load that is held is in equilibrium, as at rest.
    held = {c.identifier for c in candidates(held_scene())}
    assert held >= {'compliant_clamp', 'contact_plane', 'creep'}
    free = {c.identifier for c in candidates(filmed_scene(), fit=('damping', 'release_time'))}
    assert 'time_offset' not in free
    known = replace(RELEASE, prior_mean=0.05, prior_std=0.001)
    scene = with_release(known)
    assert 'time_offset' in {c.identifier for c in candidates(scene, fit=('release_time',))}


def stepped_explicitly():
    scene = filmed_scene()
    (setup,) = scene.observations
    motion = replace(setup.motion, integrator='semi_implicit')
    return replace(scene, observations=(replace(setup, motion=motion),))


def with_release(release: Quantity):
    scene = filmed_scene()
    (setup,) = scene.observations
    assert setup.motion is not None
    motion = replace(setup.motion, release_time=release)
    return replace(scene, observations=(replace(setup, motion=motion),))


def test_frames_of_a_recording_share_their_smooth_error() -> None:
    error = CommonError(np.full(3, 2e-4), 80.0)
    covariance = error.covariance(np.array([[10.0, 20.0], [10.0, 20.0], [400.0, 20.0]]))
    np.testing.assert_allclose(covariance[0, 1], 4e-8)
    assert abs(covariance[0, 2]) < 1e-15
