# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Held vertices: what a turn keeps, and where it ends."""

import dataclasses

from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.model import HeldPart, ObservationSetup, Turn
from diffcal_ros.scene.posing import held_targets, turn_motion, world_positions
import numpy as np
import pytest

_EXACT = 1e-14  # Metres; rounding of double precision on lengths of a metre.


@pytest.fixture
def setup(beam_mesh):
    x = beam_mesh.rest_positions[:, 0]
    turn = Turn(axis=np.array([0.6, 0.0, 0.8]), angle=np.deg2rad(400.0))
    return ObservationSetup(
        name='twisted',
        world_from_object=transform(
            rotation_matrix(np.array([0.3, -0.2, 0.5])), np.array([0.1, -0.2, 0.3])
        ),
        gravity=np.array([0.0, -9.81, 0.0]),
        held=(
            HeldPart('clamp', np.flatnonzero(x > 0.09).astype(np.int32)),
            HeldPart('far', np.flatnonzero(x < -0.09).astype(np.int32), turn),
        ),
    )


def test_world_positions_follow_the_placement(beam_mesh, setup):
    expected = apply(setup.world_from_object, beam_mesh.rest_positions)
    np.testing.assert_array_equal(world_positions(beam_mesh, setup), expected)


def test_targets_are_the_union_of_the_parts_and_start_at_rest(beam_mesh, setup):
    rest = world_positions(beam_mesh, setup)
    targets = held_targets(setup, rest, 0.0)
    np.testing.assert_array_equal(
        targets.vertices, np.sort(np.concatenate([part.vertices for part in setup.held]))
    )
    np.testing.assert_allclose(targets.positions, rest[targets.vertices], atol=_EXACT)


@pytest.mark.parametrize('fraction', [0.1, 0.5, 1.0])
def test_a_turn_is_rigid_and_keeps_its_axis(beam_mesh, setup, fraction):
    rest = world_positions(beam_mesh, setup)
    far = setup.held[1]
    targets = held_targets(setup, rest, fraction)
    moved = targets.positions[np.searchsorted(targets.vertices, far.vertices)]
    own = rest[far.vertices]
    between = np.linalg.norm(own[:, None] - own[None], axis=-1)
    np.testing.assert_allclose(
        np.linalg.norm(moved[:, None] - moved[None], axis=-1), between, atol=_EXACT
    )
    np.testing.assert_allclose(moved @ far.turn.axis, own @ far.turn.axis, atol=_EXACT)
    clamp = setup.held[0].vertices
    stayed = targets.positions[np.searchsorted(targets.vertices, clamp)]
    np.testing.assert_array_equal(stayed, rest[clamp])


def test_angles_above_a_full_turn_go_all_the_way(beam_mesh, setup):
    """400 degrees end where 40 do, but on the way there they pass 180."""
    rest = world_positions(beam_mesh, setup)
    far = setup.held[1]
    own = rest[far.vertices]
    short = dataclasses.replace(far.turn, angle=np.deg2rad(40.0))
    np.testing.assert_allclose(
        turn_motion(far.turn, own, 1.0), turn_motion(short, own, 1.0), atol=1e-13
    )
    np.testing.assert_allclose(
        turn_motion(far.turn, own, 0.45)[:3, :3],
        rotation_matrix(far.turn.axis * np.pi),
        atol=1e-13,
    )


def test_without_centre_the_middle_of_the_box_stays(beam_mesh, setup):
    own = world_positions(beam_mesh, setup)[setup.held[1].vertices]
    middle = 0.5 * (own.min(axis=0) + own.max(axis=0))
    np.testing.assert_allclose(
        apply(turn_motion(setup.held[1].turn, own, 0.3), middle), middle, atol=_EXACT
    )


def test_centre_and_translation_are_in_the_world():
    turn = Turn(
        axis=np.array([0.0, 0.0, 1.0]),
        angle=np.pi / 2,
        center=np.array([1.0, 0.0, 0.0]),
        translation=np.array([0.0, 0.0, 0.2]),
    )
    rest = np.array([[2.0, 0.0, 0.0], [1.0, 0.0, 5.0]])
    moved = apply(turn_motion(turn, rest, 1.0), rest)
    np.testing.assert_allclose(moved, [[1.0, 1.0, 0.2], [1.0, 0.0, 5.2]], atol=_EXACT)
    half = apply(turn_motion(turn, rest, 0.5), rest)
    np.testing.assert_allclose(half[1], [1.0, 0.0, 5.1], atol=_EXACT)


def test_more_rows_than_vertices_are_welcome(beam_mesh, setup):
    """Elements with mid-edge nodes append those to the vertices."""
    rest = world_positions(beam_mesh, setup)
    longer = np.vstack([rest, np.full((5, 3), 7.0)])
    np.testing.assert_array_equal(
        held_targets(setup, longer).positions, held_targets(setup, rest).positions
    )


def test_a_fraction_beyond_the_turn_is_refused(beam_mesh, setup):
    with pytest.raises(ValueError, match=r'fraction is 1\.5: a turn is done from 0 to 1'):
        held_targets(setup, world_positions(beam_mesh, setup), 1.5)
