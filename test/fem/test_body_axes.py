# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Axes of a clamped body, and of the section where its clamp ends."""

from dataclasses import replace

from diffcal_ros.errors import InputError
from diffcal_ros.fem.body_axes import body_axes
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion.inputs import Release
from diffcal_ros.fem.motion.moving_body import MovingBody
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.model import HeldPart, ObservationSetup, Scene
from diffcal_ros.scene.posing import object_axes
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.scenes import beam_scene

TURN = transform(rotation_matrix(np.array([0.4, -0.7, 0.9])), np.array([0.3, -0.2, 1.1]))


def _hooked(points: np.ndarray) -> np.ndarray:
    """Bend what is beyond the first third downwards; the clamp's end stays as it is."""
    along = np.maximum(points[:, 0] - 0.04, 0.0)
    return points - np.outer(9.0 * along**2, [0.0, 1.0, 0.0])


@pytest.fixture
def scene() -> Scene:
    return beam_scene((6, 3, 2))


def _setup(scene: Scene) -> ObservationSetup:
    held = held_end(beam_mesh((6, 3, 2))).astype(np.int32)
    return replace(scene.observations[0], held=(HeldPart('clamp', held),))


def test_the_section_is_that_of_the_clamp_however_the_body_goes_on(scene):
    straight = beam_mesh((6, 3, 2))
    sides = np.ptp(straight.rest_positions, axis=0)
    wide = int(np.argmax(sides[1:])) + 1
    expected = np.eye(3)[[0, wide, 3 - wide]]
    mesh = TetMesh(_hooked(straight.rest_positions), straight.tets)
    axes = object_axes(mesh, _setup(scene))
    assert abs(axes.axes[0] @ expected[0]) < 0.99, 'the body itself goes elsewhere'
    np.testing.assert_allclose(np.abs(axes.section @ expected.T), np.eye(3), atol=1e-6)
    assert axes.section[0] @ expected[0] > 0.0, 'towards the free part'


def test_the_section_turns_with_the_body(scene):
    mesh = beam_mesh((6, 3, 2))
    here = object_axes(mesh, _setup(scene))
    moved = TetMesh(apply(TURN, mesh.rest_positions), mesh.tets)
    there = object_axes(moved, _setup(scene))
    placed = here.placed(TURN)
    np.testing.assert_allclose(placed.section[0], there.section[0], atol=1e-9)
    cosines = np.abs(np.sum(placed.section * there.section, axis=1))
    np.testing.assert_allclose(cosines, 1.0, atol=1e-9)


def test_without_a_border_the_whole_held_part_counts():
    mesh = beam_mesh((6, 3, 2))
    axes = body_axes(mesh.rest_positions, held_end(mesh).astype(np.int32))
    np.testing.assert_allclose(axes.section @ axes.section.T, np.eye(3), atol=1e-12)


def test_axes_of_large_bodies_take_no_more_room_than_their_points():
    # A square of so many would be 320 GB.
    rest = np.random.default_rng(6).random((250_000, 3)) * [0.3, 0.1, 0.05]
    axes = body_axes(rest, np.flatnonzero(rest[:, 0] < 0.25).astype(np.int32))
    np.testing.assert_allclose(axes.section @ axes.section.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize('free', [1, 2])
def test_a_body_with_hardly_a_free_node_has_axes(free):
    """A support may hold all but a few until it lets go."""
    rest = beam_mesh((6, 3, 2)).rest_positions
    axes = body_axes(rest, np.arange(free, len(rest), dtype=np.int32)).axes
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)


def test_a_support_that_leaves_nothing_free_is_refused():
    mesh = beam_mesh((3, 1, 1))
    everything = np.arange(mesh.vertex_count, dtype=np.int32)
    clamp = held_end(mesh)
    support = np.setdiff1d(everything, clamp).astype(np.int32)
    body = StaticBody(mesh, Element.LINEAR, clamp)
    with pytest.raises(InputError, match='leave some of them free to deform'):
        MovingBody(body, Release(support, 0.0))


def test_places_across_a_straight_body_are_those_of_its_box():
    mesh = beam_mesh((6, 3, 2))
    axes = body_axes(mesh.rest_positions, held_end(mesh).astype(np.int32))
    own = axes.on_surface(mesh.rest_positions, mesh.surface_triangles)
    expected = axes.places(mesh.rest_positions, mesh.rest_positions)[mesh.surface_triangles]
    np.testing.assert_allclose(own, expected, atol=1e-9)
    sides = axes.sides(mesh.rest_positions, mesh.surface_triangles)
    # Whoever faces across is at that side, and the ends face along.
    for way in (0, 1):
        on = np.abs(np.abs(sides[:, way]) - 1.0) < 1e-9
        np.testing.assert_allclose(own[on][:, :, 1 + way], sides[on, None, way].repeat(3, 1))
    assert np.isclose(np.abs(sides).sum(axis=1), 0.0, atol=1e-9).sum() == 2 * 2 * 3 * 2


def test_places_across_follow_a_body_that_is_bent_and_waisted():
    """A strip along each body is the same one, whatever its sections are like."""
    straight = beam_mesh((24, 3, 2))
    clamp = held_end(straight).astype(np.int32)
    before = body_axes(straight.rest_positions, clamp)
    rest = straight.rest_positions.copy()
    share = before.fraction(rest)
    own = (rest - before.root) @ before.axes.T
    own[:, 1] *= 1.0 - 0.3 * share
    own[:, 2] = own[:, 2] + 0.01 * share**2
    rest = before.root + own @ before.axes
    after = body_axes(rest, clamp)
    triangles = straight.surface_triangles
    found = after.on_surface(rest, triangles)
    # Its own axes lean by what it is bent, and sections with them.
    np.testing.assert_allclose(
        found, before.on_surface(straight.rest_positions, triangles), atol=0.12
    )
    along = after.axes[0] @ before.axes[0]
    assert along > 0.99
    plain = after.places(rest, rest)[triangles]
    assert (
        np.abs(
            plain - before.places(straight.rest_positions, straight.rest_positions)[triangles]
        ).max()
        > 0.3
    )


@pytest.mark.parametrize('far', [False, True])
def test_a_body_that_is_held_amid_its_length_goes_from_end_to_end(far):
    """Each arm has places of its own; a stub behind a clamp is no arm."""
    rest = beam_mesh((20, 2, 2)).rest_positions
    share = (rest[:, 0] - rest[:, 0].min()) / np.ptp(rest[:, 0])
    low = 0.4 if far else 0.1
    held = np.flatnonzero((share > low - 0.01) & (share < low + 0.11)).astype(np.int32)
    axes = body_axes(rest, held)
    told = axes.fraction(rest)
    told = told if axes.axes[0][0] > 0.0 else 1.0 - told
    begin = 0.0 if far else 0.2
    np.testing.assert_allclose(told, np.clip((share - begin) / (1.0 - begin), 0.0, 1.0), atol=1e-9)
