# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Energy laws of a scene: read, chosen, written again, refused."""

from diffcal_ros.errors import SceneError
from diffcal_ros.fem.laws import law_names
from diffcal_ros.scene.law_choice import with_law
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.save import save_fitted_scene
import pytest


@pytest.mark.parametrize('law', law_names())
def test_a_scene_names_its_law(write_scene, law):
    assert load_scene(write_scene({'law': {'name': law}})).law == law


def test_a_chosen_law_is_written_with_the_fitted_scene(write_scene, tmp_path):
    scene = load_scene(write_scene({'law': {'lame_convention': 'consistent'}}))
    chosen = with_law(scene, 'mooney_rivlin')
    assert (scene.law, chosen.law) == ('stable_neo_hookean', 'mooney_rivlin')
    save_fitted_scene(chosen, tmp_path / 'fitted.yaml', {'youngs_modulus': 7e4})
    assert load_scene(tmp_path / 'fitted.yaml').law == 'mooney_rivlin'
    assert load_scene(scene.path).law == 'stable_neo_hookean'


def test_the_papers_numbers_go_with_one_law_only(write_scene):
    changes = {'law': {'name': 'mooney_rivlin', 'lame_convention': 'paper'}}
    with pytest.raises(SceneError, match=r'lame_convention is .paper.: it is known of stable_neo'):
        load_scene(write_scene(changes))
    paper = load_scene(write_scene({'law': {'lame_convention': 'paper'}}))
    with pytest.raises(SceneError, match='lame_convention is paper, which is known of stable_neo'):
        with_law(paper, 'linear_elastic')


def test_an_unknown_law_is_refused(write_scene):
    with pytest.raises(SceneError, match="law is 'ogden': use one of stable_neo_hookean, linear"):
        with_law(load_scene(write_scene()), 'ogden')
