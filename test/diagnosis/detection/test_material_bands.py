# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bands of one height are found where they begin and end; what is smooth is none."""

from dataclasses import replace
from itertools import product

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.depth_discontinuity import Jumps
from diffcal_ros.diagnosis.detection.material_bands import best_borders, find_bands
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.effects import bands
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS
from support.watched import watched, with_step

COUNTS = (16, 2, 2)
SCENE = beam_scene(COUNTS)
BORDERS = (0.3, 0.45, 0.7)
HEIGHT = 0.004


def _banded(borders=BORDERS, height=HEIGHT):
    seen = watched(seed=4)
    for number, at in enumerate(borders):
        seen = with_step(seen, at, height if number % 2 == 0 else -height, COUNTS)
    return seen


def _ramped(begin, end, height, steps=12):
    seen = watched(seed=4)
    for at in np.linspace(begin, end, steps):
        seen = with_step(seen, at, height / steps, COUNTS)
    return seen


def _strips(residual, places):
    """Return the jumps of a line of pixels, shape (n,), beyond each place (index)."""
    columns = np.array([np.arange(len(residual)) >= place for place in places], dtype=float).T
    return Jumps(columns.T @ columns, columns.T @ residual, float(residual @ residual))


@pytest.mark.parametrize('seed', range(6))
def test_no_set_of_borders_is_worth_more_than_the_one_that_is_found(seed):
    random = np.random.default_rng(seed)
    places = np.arange(4, 40, 4)
    residual = 3.0 * random.normal(size=44) + 8.0 * (np.arange(44) // 9 % 2)
    jumps = _strips(residual, places)
    found = best_borders(jumps)
    price = 2.0 * np.log(47)

    def worth(chosen):
        signs = np.zeros(len(places))
        signs[np.flatnonzero(chosen)] = [(-1.0) ** n for n in range(sum(chosen))]
        return float(jumps.gains(signs[None])[0][0]) - price * sum(chosen)

    sets = [chosen for chosen in product((0, 1), repeat=len(places)) if 0 < sum(chosen) <= 8]
    assert worth(found.astype(int)) == pytest.approx(max(map(worth, sets)))


def test_the_gain_of_bands_is_that_of_a_fit_of_their_height():
    random = np.random.default_rng(3)
    band = ((np.arange(60) >= 12) & (np.arange(60) < 30)) | (np.arange(60) >= 41)
    residual = 0.01 * random.normal(size=60) + 0.02 * band
    # All three columns differ in size, and the signs are not those of any one border.
    jumps = _strips(residual, [12, 30, 41])
    gains, heights = jumps.gains(np.array([[1.0, -1.0, 1.0]]))
    usual = 0.005
    rows = np.append(band.astype(float), 1.0 / usual)
    values = np.append(residual, 0.0)
    height = float(rows @ values / (rows @ rows))
    assert heights[0] == pytest.approx(height, rel=1e-12)
    left = float(np.sum((values - rows * height) ** 2))
    assert gains[0] == pytest.approx(jumps.whole - left, rel=1e-9)


def test_bands_are_found_where_they_begin_and_end():
    evaluator, _ = fit_nominal(SCENE, [_banded()], None)
    found = evaluator.model.scene.effects
    assert found['depth_bias_by_region'] == found['stiffness_contrast']
    # A layer of elements is 0.07 of the free length.
    assert bands.borders(found['depth_bias_by_region']) == pytest.approx(BORDERS, abs=0.01)


@pytest.mark.parametrize(
    'look',
    [
        pytest.param(lambda: watched(seed=4), id='nothing'),
        pytest.param(lambda: watched(seed=4, tilt=0.06), id='tilt'),
        pytest.param(lambda: _ramped(0.25, 0.75, 0.004), id='ramp'),
        pytest.param(lambda: with_step(watched(seed=4), 0.3, 0.0015, COUNTS), id='one step'),
        pytest.param(
            lambda: replace(_banded(), frame_count=1, noise=np.nan),
            id='bands, but the floor is a guess',
        ),
    ],
)
@pytest.mark.slow_but_first
def test_what_is_no_bands_is_not_taken_for_them(look):
    evaluator, nominal = fit_nominal(SCENE, [look()], None)
    assert find_bands(evaluator, nominal)[0] == ()
    borders = bands.borders(evaluator.model.scene.effects.get('depth_bias_by_region', {}))
    assert len(borders) == 1


def test_what_is_left_of_narrow_bands_is_not_taken_for_something_before_the_body():
    """Beside their borders few patches show them: the rest agrees, and they would be left out."""
    evaluator, nominal = fit_nominal(SCENE, [_banded((0.4, 0.55, 0.8), 0.006)], None)
    assert len(bands.borders(evaluator.model.scene.effects['depth_bias_by_region'])) > 1
    assert evaluator.left_out == frozenset()
    assert patch_gap(nominal.groups, Part.ALL).rms > 0.002


def test_borders_that_a_scene_states_stay():
    stated = {'at': 0.3, 'until': 0.6}
    scene = replace(SCENE, effects={'depth_bias_by_region': stated})
    evaluator, _ = fit_nominal(scene, [_banded()], None)
    assert evaluator.model.scene.effects == {'depth_bias_by_region': stated}


@pytest.mark.slow
def test_bands_are_named_and_the_modulus_heals():
    diagnosis = diagnose(SCENE, [_banded()]).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'depth_bias_by_region'
    assert effect.amplitude['bias'] == pytest.approx(1e3 * HEIGHT, abs=0.4)
    assert bands.borders(effect.setting) == pytest.approx(BORDERS, abs=0.01)
    after = diagnosis.parameters['after']['youngs_modulus']['value']
    assert abs(after / MODULUS - 1.0) < 0.05
