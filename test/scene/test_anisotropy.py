# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Anisotropy in scene files: a direction with signs, its default, and what is refused."""

from diffcal_ros.calibration.forward.effect_model import EffectModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.errors import SceneError
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest

TURNED = {'placement.rotation_vector_deg': [0.0, 0.0, 90.0]}


def fibres(scene):
    model = EffectModel(scene, make_parameters(scene, ('youngs_modulus',)))
    amplitudes = model.amplitudes(np.zeros(2))
    rest = scene.mesh.rest_positions
    (own,) = model.conditions(amplitudes, 0, rest).potentials
    return own


def test_direction_is_the_object_s(write_scene):
    effects = {'anisotropy': {'ratio': 2.5, 'x': -0.6, 'y': 0.8}}
    found = fibres(load_scene(write_scene({**TURNED, 'effects': effects})))
    assert found.ratio == 2.5
    np.testing.assert_allclose(found.direction, [-0.8, -0.6, 0.0], atol=1e-12)


def test_default_runs_along_the_body_away_from_its_clamp(write_scene):
    scene = load_scene(write_scene({**TURNED, 'effects': {'anisotropy': {'ratio': 1.0}}}))
    np.testing.assert_allclose(fibres(scene).direction, [0.0, -1.0, 0.0], atol=1e-3)


@pytest.mark.parametrize(
    ('entry', 'words'),
    [
        ({'ratio': -1.0}, 'anisotropy.ratio is -1: give a number in 1, at least 0'),
        ({'ratio': 1.0, 'x': 2.0}, 'anisotropy.x is 2: give a number at least -1 and at most 1'),
        ({'ratio': 1.0, 'w': 1.0}, 'anisotropy.w is no key that is known here'),
    ],
)
def test_wrong_directions_are_refused(write_scene, entry, words):
    with pytest.raises(SceneError, match=words):
        load_scene(write_scene({'effects': {'anisotropy': entry}}))
