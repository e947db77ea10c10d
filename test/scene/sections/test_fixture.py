# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The section `fixture`: a block or a surface, outward, in metres of the object frame."""

from diffcal_ros.errors import SceneError
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.save import save_fitted_scene
import numpy as np
import pytest
import trimesh

BOX = {'x': [-0.03, 0.01], 'y': [0.0, 0.05], 'z': [-0.02, 0.04]}


def surface_of(fixture):
    return trimesh.Trimesh(fixture.positions, fixture.triangles, process=False)


def test_without_the_section_there_is_none(write_scene):
    assert load_scene(write_scene()).fixture is None


def test_a_box_becomes_a_closed_block_that_faces_outward(write_scene):
    surface = surface_of(load_scene(write_scene({'fixture': {'box': BOX}})).fixture)
    assert surface.is_watertight
    assert surface.is_winding_consistent
    # An inward one would have a negative volume.
    assert surface.volume == pytest.approx(0.04 * 0.05 * 0.06)
    np.testing.assert_allclose(surface.bounds, np.array([BOX[axis] for axis in 'xyz']).T)


def test_the_blocks_of_two_clamps_are_one_fixture(write_scene, tmp_path):
    other = {**BOX, 'x': [0.1, 0.12]}
    scene = load_scene(write_scene({'fixture': {'boxes': [BOX, other]}}))
    surface = surface_of(scene.fixture)
    assert surface.is_watertight
    assert surface.volume == pytest.approx((0.04 + 0.02) * 0.05 * 0.06)
    assert len(surface.split()) == 2
    np.testing.assert_allclose(surface.bounds[:, 0], [-0.03, 0.12])
    save_fitted_scene(scene, tmp_path / 'out' / 'fitted.yaml', {})
    again = load_scene(tmp_path / 'out' / 'fitted.yaml')
    np.testing.assert_array_equal(again.fixture.positions, scene.fixture.positions)


@pytest.mark.parametrize('is_inside_out', [False, True])
def test_a_surface_file_is_taken_in_its_unit_and_turned_outward(
    write_scene, tmp_path, is_inside_out
):
    clamp = trimesh.creation.cone(radius=20.0, height=35.0)
    if is_inside_out:
        clamp.invert()
    clamp.export(tmp_path / 'clamp.stl')
    path = write_scene({'fixture': {'file': 'clamp.stl', 'unit': 'mm'}})
    surface = surface_of(load_scene(path).fixture)
    assert surface.volume == pytest.approx(1e-9 * abs(clamp.volume), rel=1e-6)
    np.testing.assert_allclose(surface.bounds, 1e-3 * clamp.bounds, atol=1e-9)


def test_a_fitted_scene_elsewhere_finds_the_same_surface(write_scene, tmp_path):
    trimesh.creation.box(extents=(30.0, 40.0, 50.0)).export(tmp_path / 'clamp.stl')
    scene = load_scene(write_scene({'fixture': {'file': 'clamp.stl', 'unit': 'mm'}}))
    save_fitted_scene(scene, tmp_path / 'out' / 'fitted.yaml', {})
    again = load_scene(tmp_path / 'out' / 'fitted.yaml')
    np.testing.assert_array_equal(again.fixture.positions, scene.fixture.positions)


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        ({'box': BOX, 'file': 'clamp.stl'}, 'names no single shape'),
        ({'colour': 'grey'}, 'names no single shape'),
        ({'box': BOX, 'boxes': [BOX]}, 'names no single shape'),
        ({'boxes': []}, 'give a list'),
        ({'boxes': [BOX, {'x': [0.0, 0.1]}]}, 'limit x, y and z'),
        ({'boxes': [BOX, {**BOX, 'y': [0.05, 0.0]}]}, r'boxes\[1\]\.y .*swap them'),
        ({'boxes': [BOX, 3]}, r'boxes\[1\] is no mapping'),
        ({'box': {'x': [0.0, 0.1]}}, 'limit x, y and z'),
        ({'box': {**BOX, 'z': [-20.0, 40.0]}}, 'in metres'),
        ({'file': 'nowhere.stl', 'unit': 'mm'}, 'there must be a surface there'),
        ({'file': 'block.stl', 'unit': 'm'}, 'metres from the body'),
        ({'file': 'open.stl', 'unit': 'mm'}, 'not watertight'),
    ],
)
def test_a_mistake_is_told_with_what_is_needed(write_scene, tmp_path, given, words):
    block = trimesh.creation.box(extents=(30.0, 40.0, 50.0))
    block.export(tmp_path / 'block.stl')
    block.update_faces(np.arange(len(block.faces)) > 0)
    block.export(tmp_path / 'open.stl')
    with pytest.raises(SceneError, match=words) as caught:
        load_scene(write_scene({'fixture': given}))
    assert 'fixture' in str(caught.value)
