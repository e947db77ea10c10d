# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Suggestions: information adds up, gravity the other way helps, impossible views are left out."""

from dataclasses import replace
import json

from diffcal_ros.cli.main import main
from diffcal_ros.errors import SceneError
from diffcal_ros.planning.candidates import make_candidates
from diffcal_ros.planning.suggest import _as_recorded, suggest
from diffcal_ros.report.tables.suggestion_text import suggestion_text
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Quantity
import numpy as np
import pytest
from support.recorded_beam import COLOR_CAMERA, DEPTH_CAMERA, write_beam_scene


@pytest.fixture(scope='module')
def scene(tmp_path_factory):
    loaded = load_scene(write_beam_scene(tmp_path_factory.mktemp('scene')))
    return replace(loaded, depth_camera=DEPTH_CAMERA, color_camera=COLOR_CAMERA)


@pytest.fixture(scope='module')
def suggestion(scene):
    return suggest(scene, fit=('youngs_modulus', 'rigid_offset'))


def test_the_same_once_more_is_worth_half_a_bit(suggestion):
    """Twice the data of one parameter without a prior: errors fall by the root of two."""
    (again,) = [one for one in suggestion.ranked if one.name == 'again']
    before = suggestion.now.errors['youngs_modulus']
    # A rigid offset is the same in both, and its prior holds it: not quite, therefore.
    assert again.errors['youngs_modulus'] == pytest.approx(before / np.sqrt(2.0), rel=0.05)
    assert again.bits == pytest.approx(0.5, abs=0.07)


def test_ranking_and_bits_agree_with_the_errors(suggestion):
    bits = [one.bits for one in suggestion.ranked]
    assert bits == sorted(bits, reverse=True)
    assert min(bits) >= 0.0
    for one in suggestion.ranked:
        fall = suggestion.now.errors['youngs_modulus'] / one.errors['youngs_modulus']
        assert one.bits == pytest.approx(np.log2(fall), abs=1e-6)


def test_gravity_the_other_way_tells_sag_from_a_wrong_placement(suggestion):
    by_name = {one.name: one for one in suggestion.ranked}
    assert by_name['gravity +y'].bits > by_name['again'].bits + 0.3


def test_modulus_and_density_stay_unknown_at_rest_whatever_is_recorded(scene):
    (region,) = scene.regions
    open_scene = replace(scene, regions=(replace(region, density=Quantity(1080.0, 100.0, 1e4)),))
    suggestion = suggest(open_scene, fit=('youngs_modulus', 'density'))
    for one in suggestion.ranked:
        assert one.errors['density'] > 0.3 * 1080.0, one.name


def test_views_go_around_the_body_and_keep_the_marker_in_sight(scene):
    now, middle = _as_recorded(scene, scene.observations[0])
    candidates, refused = make_candidates(now, middle, scene.marker)
    distance = np.linalg.norm(apply(now.depth_from_world, middle))
    for candidate in candidates:
        assert np.linalg.norm(apply(candidate.depth_from_world, middle)) == pytest.approx(distance)
    assert len({candidate.name for candidate in candidates}) == len(candidates)
    assert not any(candidate.name == 'gravity -y' for candidate in candidates)
    everywhere, none = make_candidates(now, middle, None)
    assert none == []
    assert len(everywhere) == len(candidates) + len(refused)
    assert {one.reason for one in refused} <= {'the marker would be turned away'}


def test_text_says_the_best_first_and_what_was_assumed(suggestion):
    first, *rows = suggestion_text(suggestion).splitlines()
    assert first.startswith(suggestion.ranked[0].words.capitalize()[:20])
    assert 'Young' in first
    assert '%' in first
    assert rows[-1].startswith('assumed')


def test_command_prints_and_writes_json(tmp_path, capsys):
    path = write_beam_scene(tmp_path)
    assert main(['suggest', str(path), '--json', str(tmp_path / 'next.json')]) == 0
    assert '1.' in capsys.readouterr().out
    content = json.loads((tmp_path / 'next.json').read_text())
    assert content['candidates'][0]['bits'] >= content['candidates'][-1]['bits']
    assert main(['suggest', str(path), '--fit', 'youngs_modulos']) == 2


def test_nothing_of_the_body_is_refused(scene):
    with pytest.raises(SceneError, match='nothing of the body is fitted'):
        suggest(scene, fit=('rigid_offset',))


def test_motion_is_refused(tmp_path):
    path = write_beam_scene(
        tmp_path,
        {
            'held': {
                'clamp': {'box': {'x': [0.1, 1.0]}},
                'end': {'box': {'x': [-1.0, 0.01]}},
            },
            'motion': {'released': ['end'], 'at': 0.1},
        },
    )
    with pytest.raises(SceneError, match='made for bodies at rest'):
        suggest(load_scene(path))
