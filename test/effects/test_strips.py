# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parts across a body that are of a second material: stated, told apart, read, said."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.robust_residual import make_comparers
from diffcal_ros.diagnosis.verdict.verdict import NamedEffect
from diffcal_ros.effects import bands, strips
from diffcal_ros.report.tables.verdict_text import effect_words
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth

STATED = {'a_from': 0.25, 'b_until': 0.6}


def test_limits_are_in_half_widths_and_a_side_is_none():
    expected = [[-0.5, np.inf], [-np.inf, 0.2]]
    np.testing.assert_allclose(strips.limits(STATED), expected)
    assert strips.limits({'bias': 0.001, 'at': 0.3}) is None
    assert strips.limits(strips.SETTINGS) is None


@pytest.mark.parametrize(
    'own',
    [[[-0.5, np.inf], [-np.inf, 0.2]], [[-0.3, 0.7], [0.97, np.inf]], [[0.0, 0.1], [-0.9, 0.9]]],
)
def test_settings_of_limits_are_those_limits(own):
    np.testing.assert_allclose(strips.limits(strips.strip_settings(np.array(own))), own)


def test_points_are_within_limits_of_both_axes():
    across = np.array([[0.0, 0.0], [-0.6, 0.0], [0.0, 0.3], [1.0, -1.0], [-0.5, 0.2]])
    own = strips.limits(STATED)
    # What is at a lower limit is beyond it, as it is at a border along the body.
    assert strips.is_within(across, own).tolist() == [True, False, False, True, False]


@pytest.mark.parametrize(
    ('settings', 'words'),
    [
        ({'at': 0.3}, ''),
        (STATED, 'a 0.25 to 1, b 0 to 0.6'),
        ({'b_from': 0.985}, 'b 0.985 to 1'),
    ],
)
def test_limits_are_said(settings, words):
    assert strips.in_words(settings) == words


def test_the_camera_reads_a_part_otherwise_that_is_limited_along_and_across():
    effect = {'bias': 0.003, 'at': 0.3, 'until': 0.8, 'a_until': 0.7, 'b_until': 0.45}
    scene = replace(beam_scene((6, 2, 2)), effects={'depth_bias_by_region': effect})
    model = ForwardModel(
        scene, [observation(true_depth())], make_parameters(scene, ('youngs_modulus',))
    )
    here = model.parameters.start()
    view, comparer = model.views(here)[0], make_comparers(model)[0]
    read = comparer.read(view.trace, model.sensor(here, 0)) - view.trace.depth
    shown = np.flatnonzero(view.trace.faces.ravel() >= 0).astype(np.int32)
    along, a, b = comparer.places(view.trace, shown).T
    part = (along > 0.3) & (along <= 0.8) & (a <= 0.4) & (b <= -0.1)
    np.testing.assert_allclose(read.ravel()[shown], np.where(part, 0.003, 0.0), atol=1e-12)
    assert 50 < part.sum() < 0.4 * len(part)


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
        setting={'at': 0.3, 'until': 0.7, **strips.SETTINGS, 'a_until': 0.55},
        frame={},
        confidence=0.8,
        sentence='',
        outside_twins=(),
    )
    assert effect_words(named).endswith(
        ' at 0.3 to 0.7 of the length, across a 0 to 0.55 of the width'
    )
    whole = replace(named, setting={**bands.SETTINGS, **strips.SETTINGS})
    assert 'across' not in effect_words(whole)
