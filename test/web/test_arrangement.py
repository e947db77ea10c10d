# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a person arranges, and the scene that is written of it."""

from dataclasses import replace
from pathlib import Path

from diffcal_ros.proposal.draft import Draft
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.proposal.save_draft import save_draft
from diffcal_ros.scene.load import load_scene
from diffcal_ros.web.arrangement import arrangement_of, ends, same_hold
import numpy as np
import pytest

UP, DOWN = np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0])
# The beam reaches from -100 to 100 mm along x, with rows of vertices 25 mm apart.
PLANE = 0.075


@pytest.fixture
def draft(tmp_path, beam_mesh, write_tet):
    hold = Hold(UP, PLANE)
    return Draft(
        name='beam',
        mesh_file=write_tet(tmp_path / 'beam.tet', beam_mesh),
        unit='mm',
        bags=(Path('take'),),
        gravity=np.array([0.0, -9.81, 0.0]),
        world_from_object=np.eye(4),
        hold=hold,
        held=hold.vertices(beam_mesh),
        youngs_modulus=6e4,
        density=1080.0,
        poissons_ratio=0.49,
        remarks={'placement': ('found',), 'held': ('seen',), 'regions': ('check: density.',)},
    )


def saved(draft, arrangement, mesh, folder):
    return load_scene(save_draft(arrangement.draft(draft, mesh), folder / 'out' / 'scene.yaml'))


def test_what_is_arranged_is_what_the_saved_scene_holds(draft, beam_mesh, tmp_path):
    turn = np.array([0.3, -0.2, 0.5])
    arranged = arrangement_of(draft).placed([0.01, -0.02, 0.4], turn).held_from(0.05)
    arranged = replace(arranged, youngs_modulus=123_000.0)
    scene = saved(draft, arranged, beam_mesh, tmp_path)
    setup = scene.observations[0]
    assert setup.world_from_object == pytest.approx(arranged.world_from_object, abs=1e-5)
    assert np.array_equal(setup.held[0].vertices, arranged.hold.vertices(beam_mesh))
    assert scene.regions[0].youngs_modulus.start == 123_000.0


def test_what_was_set_by_hand_is_remarked_and_the_rest_as_proposed(draft, beam_mesh, tmp_path):
    kept = arrangement_of(draft).draft(draft, beam_mesh)
    assert kept.remarks == draft.remarks
    moved = arrangement_of(draft).placed([0.0, 0.001, 0.0], np.zeros(3)).draft(draft, beam_mesh)
    text = moved.text(tmp_path)
    assert '# found' not in text
    assert 'Set by hand on the page' in text
    assert '# seen' in text
    assert '# check: density.' in text


def test_a_place_is_read_back_as_it_was_set(draft):
    turn = np.array([0.4, 1.1, -0.7])
    arranged = arrangement_of(draft).placed([0.1, 0.2, 0.3], turn)
    assert arranged.translation == pytest.approx([0.1, 0.2, 0.3])
    assert arranged.turn == pytest.approx(turn)


def test_a_clamp_that_holds_all_or_next_to_nothing_is_told(draft, beam_mesh):
    arranged = arrangement_of(draft)
    assert arranged.problem(beam_mesh) == ''
    assert 'holds the whole body' in arranged.held_from(-0.2).problem(beam_mesh)
    assert 'holds 0 vertices' in arranged.held_from(0.2).problem(beam_mesh)


def test_the_ends_of_a_beam_are_those_of_its_long_axis(draft, beam_mesh):
    found = ends(beam_mesh, draft.hold)
    assert list(found) == ['+x', '-x']
    assert found['+x'] is draft.hold
    assert found['-x'].direction == pytest.approx(DOWN)
    assert not same_hold(found['+x'], found['-x'])
    assert same_hold(draft.hold, Hold(UP, PLANE + 1e-7))


def test_every_posture_of_a_scene_is_arranged(draft, write_scene):
    scene = load_scene(write_scene())
    twice = replace(scene, observations=scene.observations * 2)
    arranged = arrangement_of(draft).placed([0.1, 0.0, 0.0], np.zeros(3))
    there = arranged.scene(twice)
    for setup in there.observations:
        assert setup.world_from_object[0, 3] == pytest.approx(0.1)
        assert np.array_equal(setup.held[0].vertices, draft.held)
    assert there.regions[0].youngs_modulus.start == draft.youngs_modulus
