# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where materials end shows beside the body of a pair, which no effect alone has."""

from dataclasses import replace

from diffcal_ros.diagnosis.borders_seen import with_borders_seen_beside
from diffcal_ros.diagnosis.model_comparison.bodies_of_pairs import bodies_of_pairs
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.screening.candidates import candidates
import pytest
from support.clamped_anew import beam_in_two_poses, lifted
from support.watched import with_part

AT, HEIGHT = 0.35, -0.003
# The body is clamped by so much above where the scene says, in each pose [m].
LIFTS = (0.010, 0.006)


@pytest.fixture(scope='module')
def lifted_step():
    """Return the nominal evaluator and fit of a lifted body of which a step is read too near."""
    plain, seen = beam_in_two_poses(16)
    stepped = [with_part(own, {'at': AT}, HEIGHT, plain) for own in seen]
    return fit_nominal(lifted(plain, LIFTS), stepped, None)


def _pair(evaluator, nominal, reading):
    """Return a fitted pair of a displaced clamp and of a reading, which leaves more than noise."""
    listed = candidates(evaluator.model.scene)
    fullest = {
        name: max((c for c in listed if c.identifier == name), key=lambda c: len(c.components))
        for name in ('clamp_offset', reading)
    }
    pair = try_effects(evaluator, nominal, list(fullest.values()), {})
    return _leaving(pair, 3.0)


def _leaving(pair, per_patch):
    return replace(pair, fit=replace(pair.fit, chi_square=per_patch * pair.fit.patch_count))


@pytest.mark.slow
def test_a_step_shows_beside_the_clamp_that_a_pair_has(lifted_step):
    evaluator, nominal = lifted_step
    pair = _pair(evaluator, nominal, 'depth_affine')
    (body,) = bodies_of_pairs(evaluator, nominal, [pair])
    assert body.identifiers == ('clamp_offset',)
    told = pair.fit.values_by_name()
    for name, value in body.fit.values_by_name().items():
        assert value == pytest.approx(told[name], rel=1e-9, abs=1e-12)
    known, _ = with_borders_seen_beside([body], evaluator, nominal)
    borders = known.model.scene.effects
    assert borders['depth_bias_by_region']['at'] == pytest.approx(AT, abs=0.02)


@pytest.mark.slow
def test_what_leaves_noise_or_has_no_reading_tells_of_no_body(lifted_step):
    evaluator, nominal = lifted_step
    pair = _pair(evaluator, nominal, 'depth_affine')
    assert bodies_of_pairs(evaluator, nominal, [_leaving(pair, 0.5)]) == []
    tilted = _pair(evaluator, nominal, 'gravity_tilt')
    assert bodies_of_pairs(evaluator, nominal, [tilted]) == []
    assert bodies_of_pairs(evaluator, nominal, []) == []


@pytest.mark.slow
def test_a_body_that_cannot_be_simulated_alone_is_left_out(lifted_step):
    evaluator, nominal = lifted_step
    pair = _pair(evaluator, nominal, 'depth_affine')
    # Its clamp is where no camera looks.
    gone = pair.fit.coordinates.copy()
    gone[pair.fit.parameters.names.index('clamp_offset.y')] = 0.2
    lost = replace(pair, fit=replace(pair.fit, coordinates=gone))
    (body,) = bodies_of_pairs(evaluator, nominal, [lost, pair])
    assert (
        body.fit.values_by_name()
        == bodies_of_pairs(evaluator, nominal, [pair])[0].fit.values_by_name()
    )
