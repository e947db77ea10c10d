# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted scene is the same scene with other start values, from wherever it is read."""

import dataclasses
from pathlib import Path

from diffcal_ros.errors import InputError, SceneError
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.save import save_fitted_scene
import numpy as np
import pytest

BODY = {'youngs_modulus': '1e5', 'poissons_ratio': 0.49, 'density': 1080}
TWO_REGIONS = {
    'regions': {
        'low': {
            'box': {'x': [-float('inf'), 0.0]},
            **BODY,
            'youngs_modulus': {'start': 6e4, 'min': 5e3, 'max': 5e6},
        },
        'high': {'rest': True, **BODY},
    }
}


def test_only_the_named_start_values_change(write_scene, tmp_path):
    scene = load_scene(write_scene(TWO_REGIONS))
    fitted = tmp_path / 'fitted_scene.yaml'
    save_fitted_scene(scene, fitted, {'youngs_modulus.low': 58512.25, 'density': 1066.0})
    again = load_scene(fitted)
    low, high = again.regions
    assert low.youngs_modulus == dataclasses.replace(
        scene.regions[0].youngs_modulus, start=58512.25
    )
    assert high.youngs_modulus == scene.regions[1].youngs_modulus
    assert (low.density.start, high.density.start) == (1066.0, 1066.0)
    assert low.poissons_ratio == scene.regions[0].poissons_ratio
    np.testing.assert_array_equal(low.tets, scene.regions[0].tets)
    np.testing.assert_array_equal(again.mesh.rest_positions, scene.mesh.rest_positions)
    text = fitted.read_text()
    assert text.startswith('# Scene with fitted values, written by diffcal from scene.yaml.')
    assert 'youngs_modulus.low = 58512.2' in text


MOTION = {'released': ['clamp'], 'at': {'start': 0.1, 'min': 0.0, 'max': 0.3}}


def moving(**changes):
    held = {
        'clamp': {'box': {'x': [0.08, float('inf')]}},
        'root': {'box': {'x': [-float('inf'), -0.08]}},
    }
    return {'held': held, 'regions.body.damping': 50.0, 'motion': MOTION, **changes}


def test_damping_and_release_are_fitted_values_too(write_scene, tmp_path):
    scene = load_scene(write_scene(moving()))
    save_fitted_scene(scene, tmp_path / 'fitted.yaml', {'damping': 62.5, 'release_time': 0.123})
    again = load_scene(tmp_path / 'fitted.yaml')
    assert again.regions[0].damping.start == 62.5
    release = again.observations[0].motion.release_time
    assert release == dataclasses.replace(scene.observations[0].motion.release_time, start=0.123)


def test_each_observation_has_its_own_release(write_scene, tmp_path):
    names = ['a', 'b', 'c']
    scene = load_scene(write_scene(moving(observations=[{'name': name} for name in names])))
    fitted = {'release_time.a': 0.11, 'release_time.c': 0.13}
    save_fitted_scene(scene, tmp_path / 'fitted.yaml', fitted)
    again = load_scene(tmp_path / 'fitted.yaml')
    starts = [setup.motion.release_time.start for setup in again.observations]
    assert starts == [0.11, 0.1, 0.13]


def test_effects_that_were_fitted_or_accepted_are_part_of_it(write_scene, tmp_path):
    scene = load_scene(write_scene({'effects': {'added_mass': {'mass': 0.004, 'at': 0.9}}}))
    # Accepted effects stand in another file beside the scene, which the copy leaves behind.
    effects = {**scene.effects, 'depth_affine': {'scale': 0.0, 'bias': 0.003}}
    scene = dataclasses.replace(scene, effects=effects, fit=(*scene.fit, 'depth_affine.bias'))
    fitted = {'added_mass.mass': 0.005, 'gravity_tilt.a': 0.02, 'rigid_offset.x': 0.01}
    save_fitted_scene(scene, tmp_path / 'fitted.yaml', fitted)
    again = load_scene(tmp_path / 'fitted.yaml')
    assert again.effects == {
        'added_mass': {'mass': 0.005, 'at': 0.9},
        'depth_affine': {'scale': 0.0, 'bias': 0.003, 'beyond': 0.0},
        'gravity_tilt': {'a': 0.02, 'b': 0.0},
    }
    assert again.fit == scene.fit


def test_an_offset_is_kept_where_the_model_has_one(write_scene, tmp_path):
    scene = load_scene(write_scene({'effects': {'camera_offset': {'x': 0.002, 'rz': 0.1}}}))
    save_fitted_scene(scene, tmp_path / 'fitted.yaml', {'rigid_offset.x': 0.004})
    offset = load_scene(tmp_path / 'fitted.yaml').effects['camera_offset']
    assert (offset['x'], offset['rz']) == (0.004, 0.1)


def test_paths_still_lead_to_the_same_files_from_another_folder(write_scene, tmp_path):
    changes = {
        'bag': 'bag',
        'observations': [
            {'name': 'a', 'bag': 'sub/b'},
            {'name': 'c', 'bag': '/abs/d'},
            {'name': 'e'},
        ],
    }
    scene = load_scene(write_scene(changes))
    save_fitted_scene(scene, tmp_path / 'out' / 'deep' / 'fitted.yaml', {})
    again = load_scene(tmp_path / 'out' / 'deep' / 'fitted.yaml')
    bags = [setup.bag.resolve() for setup in again.observations]
    assert bags == [tmp_path / 'sub' / 'b', Path('/abs/d'), tmp_path / 'bag']
    assert again.document['mesh']['file'] == '../../beam.tet'


def test_an_absolute_mesh_path_stays(write_scene, tmp_path):
    scene = load_scene(write_scene({'mesh.file': str(tmp_path / 'beam.tet')}))
    save_fitted_scene(scene, tmp_path / 'out' / 'fitted.yaml', {})
    again = load_scene(tmp_path / 'out' / 'fitted.yaml')
    assert again.document['mesh']['file'] == str(tmp_path / 'beam.tet')


def test_the_scene_in_memory_stays_as_it_was(write_scene, tmp_path):
    scene = load_scene(write_scene(TWO_REGIONS))
    save_fitted_scene(scene, tmp_path / 'fitted.yaml', {'youngs_modulus.low': 1e4})
    assert scene.document['regions']['low']['youngs_modulus']['start'] == 6e4


@pytest.mark.parametrize(
    'name', ['youngs_modulus.middle', 'rigid_offset', 'stiffness', 'added_mass']
)
def test_unknown_names_are_refused_and_nothing_is_written(write_scene, tmp_path, name):
    scene = load_scene(write_scene(TWO_REGIONS))
    with pytest.raises(ValueError, match=f'{name} is no material number of the scene'):
        save_fitted_scene(scene, tmp_path / 'fitted.yaml', {name: 1.0})
    assert not (tmp_path / 'fitted.yaml').exists()


def test_a_scene_built_in_memory_cannot_be_written(write_scene, tmp_path):
    scene = dataclasses.replace(load_scene(write_scene()), path=None)
    with pytest.raises(ValueError, match='built in memory'):
        save_fitted_scene(scene, tmp_path / 'fitted.yaml', {})


def test_an_old_result_survives_a_failed_write(write_scene, tmp_path):
    scene = load_scene(write_scene())
    (tmp_path / 'file').write_text('in the way')
    with pytest.raises(InputError, match=r'cannot be written .*that the disk has room'):
        save_fitted_scene(scene, tmp_path / 'file' / 'fitted.yaml', {})
    assert (tmp_path / 'file').read_text() == 'in the way'


def test_an_effect_of_another_form_is_read_and_saved_with_it(write_scene, tmp_path):
    bent = {'a': 1.5, 'b': 0.0, 'a_3': 4.0, 'twist': -0.25}
    scene = load_scene(write_scene({'effects': {'rest_curvature': bent}}))
    assert scene.effects['rest_curvature'] == bent
    save_fitted_scene(scene, tmp_path / 'fitted.yaml', {})
    assert load_scene(tmp_path / 'fitted.yaml').effects['rest_curvature'] == bent


@pytest.mark.parametrize(
    ('effect', 'own', 'told'),
    [
        ('rest_curvature', {'a_7': 1.0}, 'rest_curvature.a_7 is no key'),
        ('stiffness_contrast', {'part_3': 1e3}, 'stiffness_contrast.part_3 is 1000'),
    ],
)
def test_a_form_that_no_effect_has_is_told(write_scene, effect, own, told):
    with pytest.raises(SceneError, match=told):
        load_scene(write_scene({'effects': {effect: own}}))
