# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Strips, stickers and painted sides are found where they are; what is smooth is none."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection import material_strip
from diffcal_ros.diagnosis.detection.depth_discontinuity import Jumps
from diffcal_ros.diagnosis.detection.material_strip import find_strip, Strip
from diffcal_ros.diagnosis.diagnose import diagnose, fit_nominal
from diffcal_ros.effects import bands, strips
import numpy as np
import pytest
from support.clamped_anew import rolled
from support.scenes import MODULUS
from support.watched import with_part

HEIGHT = -0.004
SCENE, SEEN = rolled((0.0, 0.8), np.zeros((2, 6)), (16, 2, 2))
STICKER = {'at': 0.3, 'until': 0.7, 'a_until': 0.55}


def _with(part, height=HEIGHT):
    return [with_part(seen, part, height, SCENE) for seen in SEEN]


def _stated(seen):
    evaluator, _ = fit_nominal(SCENE, seen, None)
    return evaluator.model.scene.effects.get('depth_bias_by_region', {})


@pytest.mark.parametrize(
    'part',
    [
        pytest.param({'at': 0.25, 'a_from': 0.6}, id='to the tip, on one side'),
        pytest.param({'at': 0.0, 'a_from': 0.3, 'a_until': 0.7}, id='all along, in the middle'),
        pytest.param(STICKER, id='a sticker'),
        pytest.param({'at': 0.3, 'b_from': 0.985}, id='a painted face'),
    ],
)
def test_a_part_is_found_where_it_is(part):
    found = _stated(_with(part))
    assert bands.borders(found) == pytest.approx(bands.borders(part), abs=0.015)
    # A modulus that has followed a part moves it by one or two of thirty pixels.
    for name, usual in strips.SETTINGS.items():
        assert found.get(name, usual) == pytest.approx(part.get(name, usual), abs=0.06)


def _leaning(height, steps=16):
    """Let what is read lean from side to side."""
    found = SEEN
    for share in np.linspace(0.05, 0.95, steps):
        part = {'at': 0.0, 'a_from': share}
        found = [with_part(seen, part, height / steps, SCENE) for seen in found]
    return found


@pytest.mark.parametrize(
    'seen',
    [
        pytest.param(SEEN, id='nothing'),
        pytest.param(_leaning(0.006), id='leaning'),
        pytest.param(_with({'at': 0.3}), id='one step'),
        pytest.param([_with(STICKER)[0], SEEN[1]], id='before one of two'),
        pytest.param(_with(STICKER)[:1], id='one pose'),
    ],
)
def test_what_is_no_part_is_not_taken_for_one(seen):
    assert not set(strips.SETTINGS) & set(_stated(seen))


def test_a_part_stands_out_from_what_bands_leave():
    scene = replace(SCENE, effects={'depth_bias_by_region': {'at': 0.5}})
    evaluator, nominal = fit_nominal(scene, _with({'at': 0.25, 'a_from': 0.6}), None)
    assert find_strip(evaluator, nominal, np.inf).settings.keys() == {'a_from'}
    # Compared with what leaves next to nothing it stands out no longer.
    assert find_strip(evaluator, nominal, 1.0) is None


def test_a_rectangle_explains_what_a_fit_of_its_height_does(random):
    along, across = len(material_strip._ALONG), len(material_strip._FROM)
    where = random.integers(0, (along, across), size=(4000, 2))
    columns = np.stack(
        [(where[:, 0] >= q) & (where[:, 1] >= p) for q in range(along) for p in range(across)],
        axis=1,
    ).astype(float)
    residual = random.normal(size=len(where))
    jumps = Jumps(columns.T @ columns, columns.T @ residual, float(residual @ residual))
    rectangles = material_strip._rectangles()
    gains = material_strip._gains(jumps, rectangles)
    limited = material_strip._limit_counts(rectangles)
    for number in random.integers(0, len(rectangles), size=40):
        begin, end, low, high = rectangles[number]
        own = (where[:, 0] >= begin) & (where[:, 0] < end)
        own &= (where[:, 1] >= low) & (where[:, 1] < high)
        usual = 0.005
        expected = residual[own].sum() ** 2 / (own.sum() + 1.0 / usual**2)
        assert gains[number] == pytest.approx(expected, abs=1e-9)
        along_limits = [begin > 0, end < along]
        assert limited[number].tolist() == [sum(along_limits), sum([low > 0, high < across])]


def test_a_strip_holds_what_is_within_its_limits():
    strip = Strip((0.2, 0.5), np.array([[-0.4, np.inf], [-np.inf, 0.1]]))
    places = np.array([[0.3, 0.0, 0.0], [0.1, 0.0, 0.0], [0.6, 0.0, 0.0], [0.3, -0.5, 0.0]])
    assert strip.holds(places).tolist() == [True, False, False, False]
    assert strip.settings == {'a_from': 0.3, 'b_until': 0.55}


@pytest.mark.slow
def test_a_sticker_is_named_and_the_modulus_heals():
    diagnosis = diagnose(SCENE, _with(STICKER)).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'depth_bias_by_region'
    assert effect.amplitude['bias'] == pytest.approx(1e3 * HEIGHT, abs=0.4)
    assert strips.in_words(effect.setting).startswith('a 0 to 0.5')
    assert set(effect.frame) == {'a', 'b'}
    after = diagnosis.parameters['after']['youngs_modulus']['value']
    assert abs(after / MODULUS - 1.0) < 0.05
