# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A proposed scene is read back as what was proposed."""

from dataclasses import replace
from pathlib import Path

from diffcal_ros.marker import Marker
from diffcal_ros.proposal.draft import Draft
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest

PLACE = transform(rotation_matrix(np.deg2rad([10.0, -40.0, 95.0])), np.array([0.1, -0.02, 0.3]))


@pytest.fixture
def draft(make_beam, tmp_path) -> Draft:
    """A beam of 200 mm that is held from -60 mm on."""
    mesh = make_beam((10, 2, 2), (0.2, 0.03, 0.02))
    lines = [f'v {x} {y} {z}' for x, y, z in (1e3 * mesh.rest_positions).tolist()]
    lines += [f't {a} {b} {c} {d}' for a, b, c, d in mesh.tets.tolist()]
    path = tmp_path / 'mesh' / 'beam.tet'
    path.parent.mkdir()
    path.write_text('\n'.join(lines) + '\n')
    hold = Hold(np.array([-1.0, 0.0, 0.0]), 0.0598)
    return Draft(
        name='a beam: "soft"',
        mesh_file=path,
        unit='mm',
        bags=(tmp_path / 'take one',),
        gravity=np.array([0.0, -9.81, 0.0]),
        world_from_object=PLACE,
        hold=hold,
        held=hold.vertices(mesh),
        youngs_modulus=123456.0,
        density=1100.0,
        poissons_ratio=0.48,
        marker=Marker('DICT_4X4_50', 3, 0.04),
        remarks={'gravity': ('check: ' + 'a word and another one ' * 9 + 'at the end.',)},
    )


def written(draft: Draft, folder: Path) -> Path:
    folder.mkdir()
    path = folder / 'scene.yaml'
    path.write_text(draft.text(folder))
    return path


def test_what_is_written_is_read_again(draft, tmp_path):
    scene = load_scene(written(draft, tmp_path / 'out'))
    setup = scene.observations[0]
    assert scene.name == 'a beam: "soft"'
    assert setup.world_from_object == pytest.approx(PLACE, abs=1e-5)
    assert setup.held[0].vertices.tolist() == draft.held.tolist()
    assert setup.bag.resolve() == (tmp_path / 'take one').resolve()
    assert setup.gravity.tolist() == [0.0, -9.81, 0.0]
    region = scene.regions[0]
    assert (region.youngs_modulus.start, region.density.start) == (123e3, 1100.0)
    assert region.poissons_ratio.start == 0.48
    assert (scene.marker.dictionary, scene.marker.id, scene.marker.side) == (
        'DICT_4X4_50',
        3,
        0.04,
    )
    assert scene.fit == ('youngs_modulus', 'rigid_offset')


def test_remarks_stand_above_their_section_in_short_lines(draft, tmp_path):
    lines = draft.text(tmp_path).splitlines()
    assert max(map(len, lines)) <= 99
    place = next(number for number, line in enumerate(lines) if line.startswith('gravity:'))
    assert lines[place - 1].startswith('#   ')
    assert lines[place - 1].endswith('at the end.')
    assert any(line.startswith('# check: a word') for line in lines[:place])


def test_several_takes_are_several_observations(draft, tmp_path):
    takes = (tmp_path / 'a', tmp_path / 'b')
    scene = load_scene(written(replace(draft, bags=takes), tmp_path / 'out'))
    assert [setup.bag.resolve() for setup in scene.observations] == [
        take.resolve() for take in takes
    ]


def test_a_frame_of_tf_is_the_world(draft, tmp_path):
    posed = replace(draft, marker=None, pose_frame='rig_link')
    pose = load_scene(written(posed, tmp_path / 'out')).observations[0].pose
    assert (pose.source, pose.world_frame) == ('tf', 'rig_link')


def test_without_marker_and_frame_the_world_is_the_cameras_own(draft, tmp_path):
    setup = load_scene(written(replace(draft, marker=None), tmp_path / 'out')).observations[0]
    assert np.array_equal(setup.stored_depth_from_world, np.eye(4))
    assert setup.pose.source == 'stored'
    assert setup.pose.spread == (0.0, 0.0)


def test_an_oblique_hold_lists_its_vertices(draft, tmp_path):
    oblique = Hold(np.array([0.6, 0.8, 0.0]), 0.05)
    scene = load_scene(
        written(replace(draft, hold=oblique, held=np.array([3, 5, 8, 21])), tmp_path / 'out')
    )
    assert scene.observations[0].held[0].vertices.tolist() == [3, 5, 8, 21]
