# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where one material ends is read off the step of depth, in a scene that knows of one only."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.material_boundary import _best_boundary
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.effects.registry import boundary_effects
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS
from support.watched import watched, with_step

SHARES = np.repeat((np.arange(50) + 0.5) / 50, 40)
BEYOND = {at: at < SHARES for at in np.linspace(0.14, 0.86, 37).round(3).tolist()}


def _profile(boundary: float, step: float, random) -> np.ndarray:
    return step * (boundary < SHARES) + random.normal(size=len(SHARES)) * 0.001


@pytest.mark.parametrize(('boundary', 'step'), [(0.24, 0.012), (0.38, -0.02), (0.7, 0.03)])
def test_a_step_is_found_where_it_is(boundary, step, random):
    at, height = _best_boundary(_profile(boundary, step, random), BEYOND)
    assert at == pytest.approx(boundary, abs=0.021)
    assert height == pytest.approx(abs(step), abs=0.002)


def test_of_borders_that_are_alike_the_middle_one_is_taken(random):
    """Whatever lies between the elements of a coarse mesh divides them alike."""
    coarse = np.floor(SHARES * 8) / 8 + 1 / 16
    beyond = {at: coarse > at for at in BEYOND}
    at, _ = _best_boundary(0.02 * (coarse > 0.3), beyond)
    assert at == pytest.approx(0.25, abs=0.03)  # Between 3/16 and 5/16.


@pytest.mark.parametrize(
    'profile',
    [
        pytest.param(0.03 * SHARES, id='ramp'),
        pytest.param(0.02 * SHARES**2, id='bend'),
        pytest.param(0.003 * (SHARES > 0.3), id='small step'),
        pytest.param(0.02 * (SHARES > 0.5), id='step in the middle, where it is sought anyway'),
        pytest.param(np.zeros(len(SHARES)), id='nothing'),
    ],
)
def test_what_is_no_step_elsewhere_moves_no_border(profile):
    assert _best_boundary(profile, BEYOND) is None


@pytest.mark.slow
def test_the_step_is_named_with_its_place_and_the_modulus_heals():
    seen = with_step(watched(seed=2), 0.3, 0.012)
    diagnosis = diagnose(beam_scene((8, 2, 2)), [seen]).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    found = {entry['identifier']: entry for entry in diagnosis.details['candidates']}
    step = found['depth_bias_by_region']
    assert step['setting']['at'] == pytest.approx(0.3, abs=0.05)
    assert step['amplitude']['bias'] == pytest.approx(12.0, abs=1.0)
    assert diagnosis.ambiguity_set[0] == 'depth_bias_by_region'
    assert diagnosis.closure > 0.7
    after = diagnosis.parameters['after']['youngs_modulus']['value']
    assert abs(after / MODULUS - 1.0) < 0.1


def test_a_border_without_amplitudes_states_no_effect():
    names = {effect.identifier for effect in boundary_effects()}
    scene = replace(beam_scene(), effects={name: {'at': 0.3} for name in names})
    listed = candidates(scene)
    assert {c.identifier for c in listed} >= names
    assert {c.at for c in listed if c.identifier in names} == {0.3}
    stated = replace(scene, effects={'stiffness_contrast': {'split': 0.5, 'at': 0.3}})
    assert 'stiffness_contrast' not in {c.identifier for c in candidates(stated)}
