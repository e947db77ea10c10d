# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bands of a second material: stated, told apart, said."""

from dataclasses import replace

from diffcal_ros.calibration.forward.effect_model import EffectModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.effects import bands
from diffcal_ros.effects.site import Tets
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.scenes import beam_scene

TWO = {'at': 0.2, 'until': 0.4, 'at_2': 0.7}


def test_borders_are_in_order_and_the_tip_is_none():
    assert bands.borders({}) == (0.5,)
    assert bands.borders(TWO) == (0.2, 0.4, 0.7)
    assert bands.borders({**bands.SETTINGS, 'at': 0.3}) == (0.3,)
    assert bands.borders({'at_2': 0.2, 'until_2': 0.3, 'at': 0.6}) == (0.2, 0.3, 0.6)


@pytest.mark.parametrize('places', [(0.3,), (0.2, 0.6), (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)])
def test_settings_of_borders_are_those_borders(places):
    assert bands.borders(bands.band_settings(places)) == places


def test_more_borders_than_can_be_stated_are_refused():
    with pytest.raises(ValueError, match='9 borders: at most 8'):
        bands.band_settings(np.linspace(0.1, 0.9, 9).tolist())


def test_every_second_stretch_is_of_the_second_material():
    shares = np.array([0.0, 0.1, 0.3, 0.5, 0.69, 0.9, 1.0])
    expected = [False, False, True, False, False, True, True]
    assert bands.is_second(shares, TWO).tolist() == expected
    assert Tets(shares, None).second(TWO).tolist() == expected
    of_mesh = np.arange(7) > 4
    assert Tets(shares, of_mesh).second(TWO).tolist() == of_mesh.tolist()


@pytest.mark.parametrize(
    ('settings', 'words'),
    [
        ({'at': 0.3}, '0.3 to the tip'),
        ({'at': 0.2, 'until': 0.45}, '0.2 to 0.45'),
        (TWO, '0.2 to 0.4 and 0.7 to the tip'),
        (
            bands.band_settings((0.1, 0.2, 0.3, 0.4, 0.5, 0.6)),
            '0.1 to 0.2, 0.3 to 0.4 and 0.5 to 0.6',
        ),
        ({'at': 1.0}, 'nowhere'),
    ],
)
def test_bands_are_said(settings, words):
    assert bands.in_words(settings) == words


def test_a_scene_states_bands_for_depth_and_for_stiffness(write_scene):
    stated = {
        'depth_bias_by_region': {'bias': 0.004, **TWO},
        'stiffness_contrast': {'split': 1.0, **TWO},
    }
    scene = load_scene(write_scene({'effects': stated}))
    # What a person did not state is not written for them.
    assert scene.effects['depth_bias_by_region'] == {'bias': 0.004, **TWO}
    assert bands.borders(scene.effects['stiffness_contrast']) == (0.2, 0.4, 0.7)
    parameters = make_parameters(scene, ('youngs_modulus',))
    model = EffectModel(scene, parameters)
    added = model.log_modulus(model.amplitudes(parameters.start()))
    middles = scene.mesh.rest_positions[scene.mesh.tets].mean(axis=1)
    # Along the body: softer, stiffer, softer, stiffer.
    stretches = np.diff(np.sign(added[np.argsort(middles[:, 0])])) != 0
    assert set(np.unique(added)) == {-0.5, 0.5}
    assert stretches.sum() == 3


def test_the_camera_reads_bands_of_the_surface_too_far():
    scene = replace(
        beam_scene((20, 2, 2)), effects={'depth_bias_by_region': {'bias': 0.004, **TWO}}
    )
    model = EffectModel(scene, make_parameters(scene, ('youngs_modulus',)))
    mesh = scene.mesh
    second = model.second_triangles(mesh.tets, mesh.surface_triangles)
    fraction = model.object_axes(0).fraction(
        mesh.rest_positions[mesh.surface_triangles].mean(axis=1)
    )
    clear = np.abs(fraction[:, None] - np.array([0.2, 0.4, 0.7])).min(axis=1) > 0.07
    assert clear.sum() > 100
    assert np.array_equal(second[clear], bands.is_second(fraction[clear], TWO))
