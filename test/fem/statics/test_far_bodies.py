# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the world's origin is, how it is turned and how a mesh is numbered are no physics."""

from dataclasses import dataclass
from functools import cache

from diffcal_ros.effects.contact_plane import Plane
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.own_frame import own_origin
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.mesh_error import MeshError
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.cable_route import route_through
from diffcal_ros.fem.terms.conditions import CableState, Conditions
from diffcal_ros.material import Material
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from scipy.linalg import block_diag
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, uniform_material
from support.far_worlds import DISTANCES, shift_by, TURN


def _uneven_mesh() -> TetMesh:
    """A beam without symmetry: no two diagonals of its cells are of one length."""
    mesh = beam_mesh((5, 2, 2))
    shaken = np.random.default_rng(7).uniform(-0.0015, 0.0015, mesh.rest_positions.shape)
    shaken[held_end(mesh)] = 0.0
    return TetMesh(mesh.rest_positions + shaken, mesh.tets)


_MESH = _uneven_mesh()
_NORMAL = np.array([0.2, 0.95, 0.1]) / np.linalg.norm([0.2, 0.95, 0.1])
# Positions round by 1e-13 m at 1 km, and equilibria are found to 1e-7 of the mean load.
_SAME = 1e-6
# Of a clamp that gives way otherwise in each direction.
_UNEVEN = np.array([[1.0, 0.2, 0.0], [0.2, 0.5, -0.1], [0.0, -0.1, 0.7]])
_VIA = np.array([[0.01, 0.022, 0.013], [0.06, 0.024, 0.011], [0.11, 0.02, 0.009]])


@dataclass(frozen=True)
class Answer:
    """What a body says, in the world frame that it was asked in."""

    moved: np.ndarray
    tangents: np.ndarray
    by_modulus: np.ndarray
    mesh_error: np.ndarray


def _material(order: np.ndarray) -> Material:
    share = _MESH.centroids[:, 0] / 0.12
    ones = np.ones(len(share))
    return Material((40e3 * (1.0 + share))[order], 0.47 * ones, 1080.0 * ones)


def _compliance(rotation: np.ndarray, shift: np.ndarray, turn: np.ndarray) -> np.ndarray:
    own: np.ndarray = block_diag(rotation @ shift @ rotation.T, rotation @ turn @ rotation.T)
    return own


def _conditions(body: StaticBody, new_from_old: np.ndarray) -> Conditions:
    rotation, shift = new_from_old[:3, :3], new_from_old[:3, 3]
    normal = rotation @ _NORMAL
    return Conditions(
        clamp_motion=np.ravel(np.array([[0.001, 0.002, 0.0], [0.0, 0.03, 0.05]]) @ rotation.T),
        clamp_compliance=_compliance(rotation, 0.003 * _UNEVEN, 0.2 * _UNEVEN),
        rest_curvature=np.array([0.5, -0.4]),
        potentials=(Plane(normal, -0.004 + float(normal @ shift)),),
        cables=tuple(CableState(0.97 * cable.route_length, 40.0) for cable in body.cables),
    )


def _changes(new_from_old: np.ndarray, order: np.ndarray) -> list[Change]:
    rotation, shift = new_from_old[:3, :3], new_from_old[:3, 3]
    turn = rotation @ np.cross([0.3, 0.1, -0.5], _NORMAL)
    effects = [
        Conditions(clamp_motion=np.concatenate([rotation[:, 2], rotation[:, 0]])),
        Conditions(clamp_compliance=_compliance(rotation, 0.0 * _UNEVEN, _UNEVEN)),
        Conditions(clamp_compliance=_compliance(rotation, _UNEVEN, 0.0 * _UNEVEN)),
        Conditions(rest_curvature=np.array([0.6, 0.8])),
        # A turn of the plane about the old origin.
        Conditions(potentials=(Plane(turn, float(turn @ shift)),)),
        Conditions(cables=(CableState(1.0, 0.0),)),
    ]
    modulus = Change(youngs_modulus=_material(order).youngs_modulus)
    return [modulus, *(Change(conditions=effect) for effect in effects)]


def _answer(new_from_old: np.ndarray, vertices: np.ndarray, tets: np.ndarray) -> Answer:
    """Ask a body with every effect, numbered anew; the answer is in the old frame and order."""
    old_of_new, new_of_old = vertices, np.argsort(vertices)
    rest = apply(new_from_old, _MESH.rest_positions)[old_of_new]
    mesh = TetMesh(rest, new_of_old[_MESH.tets[tets]].astype(np.int32))
    held = new_of_old[held_end(_MESH)].astype(np.int32)
    via = apply(new_from_old, _VIA)
    cables, axes = (route_through(mesh, via),), _axes().placed(new_from_old)
    body = StaticBody(mesh, Element.QUADRATIC, held, cables=cables, axes=axes)
    rotation = new_from_old[:3, :3]
    material = _material(tets)
    first = rest[np.unique(held)]
    state = body.solve_equilibrium(
        material,
        rotation @ GRAVITY,
        held_path=lambda fraction: first + fraction * rotation @ [0.0, 0.003, 0.001],
        conditions=_conditions(body, new_from_old),
    )
    count = mesh.vertex_count
    fields = body.tangents(_changes(new_from_old, tets))
    by_positions = np.zeros_like(state.positions)
    by_positions[:count] = (np.arange(3 * count).reshape(-1, 3) % 7)[old_of_new] @ rotation.T
    by_modulus = np.empty(mesh.tet_count)
    by_modulus[tets] = body.gradient(by_positions).youngs_modulus
    pulls = _conditions(body, new_from_old).cables
    error = MeshError(body).displacement(material, rotation @ GRAVITY, cables=pulls)
    moved = state.positions[:count] - rest
    return Answer(
        moved=(moved @ rotation)[new_of_old],
        tangents=(fields[:, :count] @ rotation)[:, new_of_old],
        by_modulus=by_modulus,
        mesh_error=(error[:count] @ rotation)[new_of_old],
    )


@cache
def _axes():
    return StaticBody(_MESH, Element.LINEAR, held_end(_MESH)).axes


@cache
def _expected() -> Answer:
    vertices, tets = np.arange(_MESH.vertex_count), np.arange(_MESH.tet_count)
    return _answer(np.eye(4), vertices, tets)


def _assert_same(found: Answer, tolerance: float) -> None:
    expected = _expected()
    for name in ('moved', 'by_modulus', 'mesh_error'):
        ours, theirs = getattr(found, name), getattr(expected, name)
        error = np.linalg.norm(ours - theirs) / np.linalg.norm(theirs)
        assert error < tolerance, (name, error)
    for ours, theirs in zip(found.tangents, expected.tangents, strict=True):
        assert np.linalg.norm(ours - theirs) < tolerance * np.linalg.norm(theirs)


@pytest.mark.parametrize('distance', DISTANCES)
def test_a_shift_of_the_world_changes_nothing(distance) -> None:
    vertices, tets = np.arange(_MESH.vertex_count), np.arange(_MESH.tet_count)
    _assert_same(_answer(shift_by(distance), vertices, tets), _SAME)


def test_a_turn_and_a_shift_of_the_world_change_nothing() -> None:
    vertices, tets = np.arange(_MESH.vertex_count), np.arange(_MESH.tet_count)
    turned = shift_by(30.0) @ transform(TURN, np.zeros(3))
    _assert_same(_answer(turned, vertices, tets), _SAME)


def test_numbers_of_vertices_and_tetrahedra_mean_nothing(random) -> None:
    vertices = random.permutation(_MESH.vertex_count)
    _assert_same(_answer(np.eye(4), vertices, random.permutation(_MESH.tet_count)), _SAME)


@pytest.mark.parametrize('element', list(Element))
@pytest.mark.parametrize(('modulus', 'nu'), [(20e3, 0.4999), (5e6, 0.3), (5e6, 0.4999)])
def test_a_body_far_away_settles_as_it_does_here(modulus, nu, element) -> None:
    found = []
    for distance in (0.0, *DISTANCES):
        far = shift_by(distance)[:3, 3]
        mesh = TetMesh(_MESH.rest_positions + far, _MESH.tets)
        body = StaticBody(mesh, element, held_end(_MESH))
        state = body.solve_equilibrium(uniform_material(mesh, modulus, nu), GRAVITY)
        found.append(state.positions - body.discretisation.rest_nodes)
    sag = np.abs(found[0]).max()
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], atol=1e-8 * sag + 1e-12)


def test_the_own_frame_is_exact_far_away_and_the_world_close_by() -> None:
    np.testing.assert_array_equal(own_origin(_MESH), 0.0)
    turned = rotation_matrix(np.array([0.4, -0.2, 0.9]))
    for distance in DISTANCES:
        far = _MESH.rest_positions @ turned.T + shift_by(distance)[:3, 3]
        body = StaticBody(TetMesh(far, _MESH.tets), Element.LINEAR, held_end(_MESH))
        assert np.abs(body.own_mesh.rest_positions).max() < 0.1
        np.testing.assert_array_equal(body.discretisation.rest_nodes, far)
