# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Strips, stickers and painted sides are found where they are; what is smooth is none."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection import rectangles
from diffcal_ros.diagnosis.detection.depth_discontinuity import Jumps, with_jumps
from diffcal_ros.diagnosis.detection.material_parts import _that_pay, as_stretches, find_parts
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.effects import bands, surface_parts
from diffcal_ros.effects.surface_parts import in_words, part_settings, parts_of, SurfacePart
import numpy as np
import pytest
from support.clamped_anew import beam_in_two_poses
from support.scenes import MODULUS
from support.watched import with_part

HEIGHT = -0.004
LAYERS = 16
STICKER = {'at': 0.3, 'until': 0.7, 'a_until': 0.55}


def _scene():
    return beam_in_two_poses(LAYERS)[0]


def _seen():
    return beam_in_two_poses(LAYERS)[1]


def _with(part, height=HEIGHT):
    return [with_part(seen, part, height, _scene()) for seen in _seen()]


def _stated(seen):
    evaluator, _ = fit_nominal(_scene(), seen, None)
    return evaluator.model.scene.effects.get('depth_bias_by_region', {})


@pytest.mark.parametrize(
    'part',
    [
        pytest.param({'at': 0.25, 'a_from': 0.6}, id='to the tip, on one side'),
        pytest.param(
            {'at': 0.0, 'a_from': 0.3, 'a_until': 0.7},
            marks=pytest.mark.slow,
            id='all along, in the middle',
        ),
        pytest.param(STICKER, id='a sticker'),
        pytest.param({'at': 0.3, 'b_from': 0.985}, marks=pytest.mark.slow, id='a painted face'),
    ],
)
@pytest.mark.slow_but_first
def test_a_part_is_found_where_it_is(part):
    found = _stated(_with(part))
    assert bands.borders(found) == pytest.approx(bands.borders(part), abs=0.015)
    # A modulus that has followed a part moves it by one or two of thirty pixels.
    for name, usual in surface_parts.SETTINGS.items():
        assert found.get(name, usual) == pytest.approx(part.get(name, usual), abs=0.06)


def _leaning(height, steps=16):
    """Let what is read lean from side to side."""
    found = _seen()
    for share in np.linspace(0.05, 0.95, steps):
        part = {'at': 0.0, 'a_from': share}
        found = [with_part(seen, part, height / steps, _scene()) for seen in found]
    return found


@pytest.mark.parametrize(
    'seen',
    [
        pytest.param(_seen, id='nothing'),
        pytest.param(lambda: _leaning(0.006), id='leaning'),
        pytest.param(lambda: _with({'at': 0.3}), id='one step'),
        pytest.param(lambda: [_with(STICKER)[0], _seen()[1]], id='before one of two'),
        pytest.param(lambda: _with(STICKER)[:1], id='one pose'),
    ],
)
@pytest.mark.slow
def test_what_is_no_part_is_not_taken_for_one(seen):
    assert not set(surface_parts.SETTINGS) & set(_stated(seen()))


@pytest.mark.slow
def test_a_part_stands_out_from_what_bands_leave():
    scene = replace(_scene(), effects={'depth_bias_by_region': {'at': 0.5}})
    evaluator, nominal = fit_nominal(scene, _with({'at': 0.25, 'a_from': 0.6}), None)
    (part,) = find_parts(evaluator, nominal, np.inf)
    assert part_settings([part]).keys() == {'at', 'a_from'}
    # Compared with what leaves next to nothing it stands out no longer.
    assert find_parts(evaluator, nominal, 1.0) == ()


@pytest.mark.parametrize(
    ('further', 'times'),
    [
        pytest.param({'at': 0.25, 'b_until': 0.7}, 0.8, id='on the next side'),
        pytest.param(
            {'at': 0.3, 'until': 0.5, 'a_until': 0.6}, -0.7, id='a sticker beside a paint'
        ),
    ],
)
@pytest.mark.slow
def test_two_parts_are_found_with_how_high_each_is(further, times):
    first = {'at': 0.6} if times < 0.0 else {'at': 0.25, 'a_from': 0.6}
    parts = [*parts_of(first), replace(parts_of(further)[0], times=times)]
    seen = [with_part(own, first, 0.008, _scene()) for own in _seen()]
    seen = [with_part(own, further, times * 0.008, _scene()) for own in seen]
    found = parts_of(_stated(seen))
    assert len(found) == 2
    order = np.argsort([-abs(own.times) for own in parts])
    for own, true in zip(found, (parts[n] for n in order), strict=True):
        assert own.begin == pytest.approx(true.begin, abs=0.02)
        assert own.end == pytest.approx(true.end, abs=0.02)
        shares = [np.clip(0.5 * (part.limits + 1.0), 0.0, 1.0) for part in (own, true)]
        np.testing.assert_allclose(*shares, atol=0.06)
        assert own.times == pytest.approx(true.times, abs=0.1)


@pytest.mark.slow
def test_two_paints_meet_where_one_ends():
    seen = [with_part(own, {'at': 0.3, 'until': 0.7}, -0.003, _scene()) for own in _seen()]
    seen = [with_part(own, {'at': 0.7}, 0.005, _scene()) for own in seen]
    outer, inner = parts_of(_stated(seen))
    assert (outer.begin, outer.end) == (pytest.approx(0.7, abs=0.02), 1.0)
    assert (inner.begin, inner.end) == pytest.approx((0.3, 0.7), abs=0.02)
    assert inner.times == pytest.approx(-0.6, abs=0.08)
    assert not np.isfinite([outer.limits, inner.limits]).any()


def test_stretches_are_between_borders_of_parts_that_have_all_the_width():
    whole = np.array([[-np.inf, np.inf]] * 2)
    nested = [SurfacePart(0.7, 1.0, whole), SurfacePart(0.3, 1.0, whole)]
    assert [(own.begin, own.end) for own in as_stretches(nested)] == [(0.3, 0.7), (0.7, 1.0)]
    apart = [SurfacePart(0.6, 0.8, whole), SurfacePart(0.2, 0.4, whole)]
    assert [(own.begin, own.end) for own in as_stretches(apart)] == [(0.2, 0.4), (0.6, 0.8)]
    limited = [*nested, SurfacePart(0.2, 0.4, np.array([[-np.inf, 0.1], [-np.inf, np.inf]]))]
    assert as_stretches(limited) == limited


def test_a_part_that_others_are_is_left_out(random):
    whole = np.array([[-np.inf, np.inf]] * 2)
    parts = [SurfacePart(at, 1.0, whole) for at in (0.3, 0.5, 0.7)]
    along = random.uniform(size=400)
    columns = 1e3 * np.stack([along > own.begin for own in parts], axis=1)
    residual = 0.004 * columns[:, 0] - 0.006 * columns[:, 2] + random.normal(size=400)
    jumps = Jumps(columns.T @ columns, columns.T @ residual, float(residual @ residual))
    kept, found = _that_pay(jumps, parts)
    assert found == [parts[0], parts[2]]
    np.testing.assert_allclose(kept.pulls, jumps.pulls[[0, 2]])
    np.testing.assert_allclose(kept.products, jumps.products[np.ix_([0, 2], [0, 2])])


def test_what_is_seen_beside_a_jump_is_what_a_fit_with_both_leaves(random):
    columns, residual = random.normal(size=(60, 4)), random.normal(size=60)
    usual = 0.005
    jumps = Jumps(columns.T @ columns, columns.T @ residual, float(residual @ residual))
    known = np.array([1.0, 0.0, -0.7, 0.2])
    beside = jumps.beside(known)
    own = np.array([0.0, 1.0, 0.4, -1.0])
    both = np.stack([columns @ known, columns @ own], axis=1)
    heights = np.linalg.solve(both.T @ both + np.eye(2) / usual**2, both.T @ residual)
    gain, height = beside.gains(own[None])
    assert height[0] == pytest.approx(heights[1], rel=1e-9)
    whole = float(residual @ residual) - float(heights @ (both.T @ residual))
    assert beside.whole - gain[0] == pytest.approx(whole, rel=1e-9)
    pair = Jumps(both.T @ both, both.T @ residual, jumps.whole)
    found, left = pair.heights()
    np.testing.assert_allclose(found, heights, rtol=1e-9)
    assert left == pytest.approx(whole, rel=1e-9)


def test_what_has_one_number_is_beyond_the_same_jumps(random):
    places = random.uniform((-0.1, -1.1, -1.1), 1.1, size=(4000, 3))
    # Some lie just where a limit does, which is not beyond it.
    places[::3, 0] = random.choice(rectangles.ALONG, size=len(places[::3]))
    places[1::3, 2] = random.choice(rectangles.FROM[1:], size=len(places[1::3]))
    jumps, numbers = rectangles.jumps_of(places), rectangles.numbers_of(places)
    _, firsts, own = np.unique(numbers, return_index=True, return_inverse=True)
    np.testing.assert_array_equal(jumps, jumps[firsts][own])
    assert len(firsts) < 0.9 * len(places)


@pytest.mark.slow
def test_pixels_that_are_alike_may_be_taken_together():
    evaluator, nominal = fit_nominal(_scene(), _seen(), None)
    plain = with_jumps(evaluator, nominal, rectangles.jumps_of)
    quick = with_jumps(evaluator, nominal, rectangles.jumps_of, rectangles.numbers_of)
    depths = [(one, other) for one, other in zip(plain, quick, strict=True) if one.kind == 'depth']
    assert len(depths) == len(_seen())
    for one, other in depths:
        found = one.patches.jacobian[:, -rectangles.jumps_of(np.zeros((1, 3))).shape[1] :]
        assert ((found > 0.0) & (found < 1.0)).any(axis=1).all()
        np.testing.assert_allclose(other.patches.jacobian, one.patches.jacobian, atol=1e-12)


@pytest.mark.parametrize('way', [0, 1])
def test_a_rectangle_explains_what_a_fit_of_its_height_does(random, way):
    along, across = len(rectangles.ALONG), len(rectangles.FROM)
    # Places of points in the middle between limits, as halves of what they are between.
    where = random.integers(0, (along, across), size=(600, 2))
    places = np.zeros((600, 3))
    places[:, 0] = rectangles.ALONG[where[:, 0]] + 0.01
    places[:, 1 + way] = np.append(-2.0, rectangles.FROM[1:])[where[:, 1]] + 0.01
    residual = random.normal(size=len(where))
    columns = rectangles.jumps_of(places)
    jumps = Jumps(columns.T @ columns, columns.T @ residual, float(residual @ residual))
    tried = rectangles._rectangles()
    gains = rectangles.gains_of(jumps, way, tried)
    limited = rectangles._limit_counts(tried)
    for number in random.integers(0, len(tried), size=40):
        begin, end, low, high = tried[number]
        own = (where[:, 0] >= begin) & (where[:, 0] < end)
        own &= (where[:, 1] >= low) & (where[:, 1] < high)
        usual = 0.005
        expected = residual[own].sum() ** 2 / (own.sum() + 1.0 / usual**2)
        assert gains[number] == pytest.approx(expected, abs=1e-9)
        along_limits = [begin > 0, end < along]
        assert limited[number].tolist() == [sum(along_limits), sum([low > 0, high < across])]


def test_the_best_rectangle_is_the_one_that_was_hidden(random):
    places = random.uniform((0.0, -1.0, -1.0), 1.0, size=(3000, 3))
    hidden = SurfacePart(0.24, 0.6, np.array([[-np.inf, np.inf], [-0.5, 0.3]]))
    residual = 40.0 * hidden.holds(places) + random.normal(size=3000)
    columns = rectangles.jumps_of(places)
    jumps = Jumps(columns.T @ columns, columns.T @ residual, float(residual @ residual))
    part, signs, _ = rectangles.best_rectangle(jumps)
    assert (part.begin, part.end) == (pytest.approx(0.24), pytest.approx(0.6))
    np.testing.assert_allclose(part.limits, hidden.limits)
    np.testing.assert_array_equal(columns @ signs, hidden.holds(places))


@pytest.mark.slow
def test_a_sticker_is_named_and_the_modulus_heals():
    diagnosis = diagnose(_scene(), _with(STICKER)).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'depth_bias_by_region'
    assert effect.amplitude['bias'] == pytest.approx(1e3 * HEIGHT, abs=0.4)
    assert ', across a 0 to 0.5' in in_words(effect.setting)
    assert set(effect.frame) == {'a', 'b'}
    after = diagnosis.parameters['after']['youngs_modulus']['value']
    assert abs(after / MODULUS - 1.0) < 0.05
