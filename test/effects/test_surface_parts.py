# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parts of a surface that a camera reads otherwise: stated, told apart, read, said."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.robust_residual import make_comparers
from diffcal_ros.diagnosis.verdict.verdict import NamedEffect
from diffcal_ros.effects import bands, surface_parts
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.effects.surface_parts import in_words, part_settings, parts_of, SurfacePart
from diffcal_ros.report.tables.verdict_text import effect_words
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth

STATED = {'a_from': 0.25, 'b_until': 0.6}


def _limits(*own):
    return np.array(own)


ALL = _limits([-np.inf, np.inf], [-np.inf, np.inf])


def test_limits_are_in_half_widths_and_a_side_is_none():
    (part,) = parts_of(STATED)
    np.testing.assert_allclose(part.limits, [[-0.5, np.inf], [-np.inf, 0.2]])
    assert (part.begin, part.end, part.times) == (0.5, 1.0, 1.0)
    np.testing.assert_array_equal(parts_of({'bias': 0.001, 'at': 0.3})[0].limits, ALL)


def test_each_part_has_settings_of_its_own():
    stated = {'at': 0.2, 'until': 0.4, 'b_from': 0.5, 'at_2': 0.7, 'a_until_2': 0.25}
    first, second = parts_of({**stated, 'times_2': -0.5})
    assert (first.begin, first.end, first.times) == (0.2, 0.4, 1.0)
    assert (second.begin, second.end, second.times) == (0.7, 1.0, -0.5)
    np.testing.assert_allclose(first.limits, [[-np.inf, np.inf], [0.0, np.inf]])
    np.testing.assert_allclose(second.limits, [[-np.inf, -0.5], [-np.inf, np.inf]])


@pytest.mark.parametrize(
    'parts',
    [
        [SurfacePart(0.3, 1.0, ALL)],
        [SurfacePart(0.4, 1.0, ALL, slants=(-0.2, 0.05))],
        [SurfacePart(0.0, 0.7, _limits([-0.5, np.inf], [-np.inf, 0.2]))],
        [
            SurfacePart(0.25, 1.0, _limits([-0.3, 0.7], [0.97, np.inf])),
            SurfacePart(0.1, 0.5, _limits([0.0, 0.1], [-0.9, 0.9]), times=-0.75),
            SurfacePart(0.6, 1.0, ALL, times=2.0),
        ],
    ],
)
def test_settings_of_parts_are_those_parts(parts):
    found = parts_of(part_settings(parts))
    assert [(p.begin, p.end, p.times) for p in found] == [(p.begin, p.end, p.times) for p in parts]
    for one, other in zip(found, parts, strict=True):
        np.testing.assert_allclose(one.limits, other.limits)
        assert one.slants == other.slants


def test_no_further_part_goes_aslant():
    with pytest.raises(ValueError, match='a further part goes aslant'):
        part_settings([SurfacePart(0.1, 0.3, ALL), SurfacePart(0.5, 1.0, ALL, slants=(0.1, 0.0))])


def test_no_more_parts_than_can_be_stated():
    with pytest.raises(ValueError, match='5 parts: at most 4'):
        part_settings([SurfacePart(0.1 * n, 0.1 * n + 0.05, ALL) for n in range(1, 6)])


def test_points_are_within_limits_of_both_axes():
    across = np.array([[0.0, 0.0], [-0.6, 0.0], [0.0, 0.3], [1.0, -1.0], [-0.5, 0.2]])
    places = np.hstack([np.full((5, 1), 0.7), across])
    (part,) = parts_of(STATED)
    # What is at a lower limit is beyond it, as it is at a border along the body.
    assert part.holds(places).tolist() == [True, False, False, True, False]
    assert not part.holds(places - (0.3, 0.0, 0.0)).any()


def test_a_slanted_border_is_farther_along_at_one_side():
    part = SurfacePart(0.5, 1.0, ALL, slants=(0.2, -0.1))
    # Beyond the sides it goes straight on.
    across = np.array([[0.0, 0.0], [1.0, 0.0], [-0.5, 0.0], [0.0, 1.0], [2.0, -2.0]])
    borders = np.array([0.5, 0.7, 0.4, 0.4, 0.8])
    places = np.hstack([borders[:, None], across])
    step = np.array([1e-6, 0.0, 0.0])
    assert part.holds(places + step).all()
    assert not part.holds(places - step).any()
    assert part.holds(places - 1e4 * step, (0.05, 0.0)).all()


def test_a_margin_moves_limits_but_for_those_at_clamp_tip_and_edges():
    part = SurfacePart(0.0, 1.0, _limits([-0.5, np.inf], [0.97, np.inf]))
    places = np.array([[0.01, 0.0, 1.0], [0.99, -0.55, 1.0], [0.5, -0.45, 1.0], [0.5, 0.0, 0.93]])
    assert part.holds(places, (0.05, 0.1)).tolist() == [True, True, True, False]
    assert part.holds(places, (-0.05, -0.1)).tolist() == [True, False, False, False]
    inner = SurfacePart(0.2, 0.6, ALL)
    ends = np.array([[0.17, 0.0, 0.0], [0.23, 0.0, 0.0], [0.58, 0.0, 0.0], [0.63, 0.0, 0.0]])
    assert inner.holds(ends, (0.05, 0.0)).tolist() == [True] * 4
    assert inner.holds(ends, (-0.05, 0.0)).tolist() == [False] * 4


@pytest.mark.parametrize(
    ('settings', 'words'),
    [
        ({'at': 0.3, 'until': 0.4, 'at_2': 0.6}, '0.3 to 0.4 and 0.6 to the tip of the length'),
        (STATED, '0.5 to the tip of the length, across a 0.25 to 1, b 0 to 0.6 of the width'),
        (
            {'at': 0.4, 'slant_a': -0.185, 'slant_b': 0.04},
            '0.4 to the tip of the length, aslant (-0.18 at a, +0.04 at b)',
        ),
        (
            {'at': 0.7, 'at_2': 0.3, 'until_2': 0.7, 'times_2': -0.5},
            '0.7 to the tip of the length and 0.3 to 0.7 of the length (-0.5 times as much)',
        ),
    ],
)
def test_parts_are_said(settings, words):
    assert in_words(settings) == words


def test_setting_limits_go_with_what_is_set():
    effect = EFFECTS['depth_bias_by_region']
    assert effect.limits_of('b_until_3') == (0.0, 1.0)
    assert effect.limits_of('slant_a') == (-1.0, 1.0)
    assert effect.limits_of('times_3') == (-5.0, 5.0)
    assert effect.part_forms(3) == ('part_2', 'part_3')
    assert set(effect.part_forms(4)) <= {part.name for part in effect.forms}
    assert not EFFECTS['stiffness_contrast'].part_forms(3)


def _read_too_far(effect):
    """Return by how much pixels of a beam are read too far [m], (n,), and where, (n, 3)."""
    scene = replace(beam_scene((6, 2, 2)), effects={'depth_bias_by_region': effect})
    model = ForwardModel(
        scene, [observation(true_depth())], make_parameters(scene, ('youngs_modulus',))
    )
    here = model.parameters.start()
    view, comparer = model.views(here)[0], make_comparers(model)[0]
    read = comparer.read(view.trace, model.sensor(here, 0)) - view.trace.depth
    shown = np.flatnonzero(view.trace.faces.ravel() >= 0).astype(np.int32)
    return read.ravel()[shown], comparer.places(view.trace, shown)


def test_the_camera_reads_a_part_otherwise_that_is_limited_along_and_across():
    effect = {'bias': 0.003, 'at': 0.3, 'until': 0.8, 'a_until': 0.7, 'b_until': 0.45}
    read, places = _read_too_far(effect)
    along, a, b = places.T
    part = (along > 0.3) & (along <= 0.8) & (a <= 0.4) & (b <= -0.1)
    np.testing.assert_allclose(read, np.where(part, 0.003, 0.0), atol=1e-12)
    assert 50 < part.sum() < 0.4 * len(part)


def test_parts_add_up_and_each_may_be_more():
    effect = {'bias': 0.004, 'at': 0.2, 'a_until': 0.5, 'at_2': 0.6, 'times_2': -0.5}
    read, places = _read_too_far({**effect, 'part_2': 0.001})
    along, a, _ = places.T
    first, second = (along > 0.2) & (a <= 0.0), along > 0.6
    np.testing.assert_allclose(read, 0.004 * first - 0.001 * second, atol=1e-12)
    assert min((first & second).sum(), (first & ~second).sum(), (second & ~first).sum()) > 50


def test_a_scene_keeps_the_limits_it_states(write_scene):
    stated = {'bias': 0.003, 'at': 0.2, 'b_from': 0.5, 'b_until': 1.0}
    scene = load_scene(write_scene({'effects': {'depth_bias_by_region': stated}}))
    assert scene.effects['depth_bias_by_region'] == {'bias': 0.003, 'at': 0.2, 'b_from': 0.5}


def test_a_named_part_is_said_with_where_it_is():
    named = NamedEffect(
        identifier='depth_bias_by_region',
        group='sensor',
        amplitude={'bias': -4.0},
        std_error={'bias': 0.1},
        unit={'bias': 'mm'},
        setting={'at': 0.3, 'until': 0.7, **surface_parts.SETTINGS, 'a_until': 0.55},
        frame={},
        confidence=0.8,
        sentence='',
        outside_twins=(),
    )
    assert effect_words(named).endswith(
        ' at 0.3 to 0.7 of the length, across a 0 to 0.55 of the width'
    )
    whole = replace(named, setting={**bands.SETTINGS, **surface_parts.SETTINGS})
    assert effect_words(whole).endswith(' at 0.5 to the tip of the length')
