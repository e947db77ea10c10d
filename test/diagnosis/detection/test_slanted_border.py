# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A border that goes aslant around a body is found where it is; a straight one stays straight."""

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.sharp_limits import slanted_by_pixels
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.effects.surface_parts import parts_of, SurfacePart
import numpy as np
import pytest
from support.clamped_anew import beam_in_two_poses
from support.scenes import MODULUS
from support.watched import with_part

LAYERS = 16
SLANTED = {'at': 0.45, 'slant_a': 0.17}


def _scene():
    return beam_in_two_poses(LAYERS)[0]


def _seen():
    return beam_in_two_poses(LAYERS)[1]


def _with(part, height):
    return [with_part(seen, part, height, _scene()) for seen in _seen()]


def _stated(seen):
    evaluator, _ = fit_nominal(_scene(), seen, None)
    return evaluator.model.scene.effects.get('depth_bias_by_region', {})


@pytest.mark.parametrize(
    ('part', 'height'),
    [
        pytest.param(SLANTED, -0.004, id='nearer'),
        pytest.param({'at': 0.62, 'slant_a': -0.23}, 0.009, id='far too far'),
        pytest.param(
            {'at': 0.36, 'slant_a': 0.12, 'slant_b': 0.1},
            0.006,
            marks=pytest.mark.slow,
            id='about both axes',
        ),
    ],
)
@pytest.mark.slow_but_first
def test_a_slanted_border_is_found_where_it_is(part, height):
    (found,) = parts_of(_stated(_with(part, height)))
    (true,) = parts_of(part)
    # Where it is amid the width of the side that is seen, and at the two edges of that.
    side = np.array([[0.5, across, 1.0] for across in (-0.9, 0.0, 0.9)])
    np.testing.assert_allclose(
        found.begin - found.along(side), true.begin - true.along(side), atol=0.025
    )
    assert np.isinf(found.limits).all()


def _ramped(height, steps=16):
    """Let what is read rise along the body, from one share of its length to another."""
    found = _seen()
    for at in np.linspace(0.2, 0.8, steps):
        part = {'at': at, 'slant_a': 0.15}
        found = [with_part(seen, part, height / steps, _scene()) for seen in found]
    return found


@pytest.mark.parametrize(
    'seen',
    [
        pytest.param(_seen, id='nothing'),
        pytest.param(lambda: _with({'at': 0.3}, -0.004), id='a straight border'),
        pytest.param(lambda: _ramped(0.006), id='a slope'),
        pytest.param(
            lambda: _with({'at': 0.3, 'until': 0.7, 'a_until': 0.55}, -0.004), id='a sticker'
        ),
        pytest.param(lambda: [_with(SLANTED, 0.006)[0], _seen()[1]], id='before one of two'),
    ],
)
@pytest.mark.slow
def test_what_does_not_end_aslant_is_not_said_to(seen):
    assert not {'slant_a', 'slant_b'} & set(_stated(seen()))


def test_pixels_tell_place_and_slants(random):
    places = random.uniform((0.0, -1.0, -1.0), 1.0, size=(6000, 3))
    whole = np.array([[-np.inf, np.inf]] * 2)
    true = SurfacePart(0.52, 1.0, whole, slants=(0.23, -0.11))
    residuals = 0.003 * true.holds(places) + 0.0004 * random.normal(size=len(places))
    residuals += 0.002 * places[:, 0] ** 2
    begun = SurfacePart(0.56, 1.0, whole, slants=(0.3, 0.0))
    found = slanted_by_pixels([(residuals, places)], begun)
    assert [found.begin, *found.slants] == pytest.approx([0.52, 0.23, -0.11], abs=0.015)


@pytest.mark.slow
def test_a_slanted_border_is_named_and_the_modulus_heals():
    diagnosis = diagnose(_scene(), _with({'at': 0.5, 'slant_a': -0.18}, -0.0086)).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    (effect,) = diagnosis.effects
    assert effect.identifier == 'depth_bias_by_region'
    assert effect.amplitude['bias'] == pytest.approx(-8.6, abs=0.4)
    assert effect.setting['slant_a'] == pytest.approx(-0.18, abs=0.03)
    after = diagnosis.parameters['after']['youngs_modulus']['value']
    assert abs(after / MODULUS - 1.0) < 0.05
