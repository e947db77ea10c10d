# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rotations around nodes, and factorisations that turn with them."""

from dataclasses import replace

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.elements.node_rotations import NodeRotations
from diffcal_ros.fem.elements.turned_factor import TurnedFactor
from diffcal_ros.fem.laws import linear_elastic, stable_neo_hookean
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.statics.tangent_stiffness import TangentStiffness
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, hanging_beam, uniform_material

TURN = rotation_matrix(np.array([0.4, -1.0, 2.0]))


def _factored(law, random) -> tuple[TangentStiffness, np.ndarray, np.ndarray]:
    """A stiffness factored where its body hangs, that place, and a right side."""
    mesh = beam_mesh((4, 1, 2))
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh), law=law)
    material = replace(uniform_material(mesh, 60e3), conversion=law.CONVERSION)
    positions = body.solve_equilibrium(material, GRAVITY).positions
    stiffness = body.solver.stiffness
    stiffness.factor(positions)
    return stiffness, positions, random.normal(size=stiffness.pattern.size)


def test_a_body_that_has_turned_is_solved_for_at_once(random) -> None:
    stiffness, positions, right_side = _factored(stable_neo_hookean, random)
    before = stiffness.iterate(positions, right_side, 1e-9, 0)
    turned = (right_side.reshape(-1, 3) @ TURN.T).ravel()
    found = stiffness.iterate(positions @ TURN.T, turned, 1e-9, 0)
    assert before is not None
    assert found is not None
    expected = before.reshape(-1, 3) @ TURN.T
    np.testing.assert_allclose(found.reshape(-1, 3), expected, atol=1e-8 * np.abs(expected).max())


def test_a_law_that_feels_turns_keeps_its_factorisation(random) -> None:
    stiffness, positions, right_side = _factored(linear_elastic, random)
    before = stiffness.iterate(positions, right_side, 1e-9, 0)
    # Its stiffness is the same everywhere.
    found = stiffness.iterate(positions @ TURN.T, right_side, 1e-9, 0)
    assert before is not None
    assert found is not None
    np.testing.assert_allclose(found, before, atol=1e-12 * np.abs(before).max())


def test_a_new_factorisation_begins_unturned(random) -> None:
    stiffness, positions, right_side = _factored(stable_neo_hookean, random)
    assert stiffness.iterate(positions @ TURN.T, right_side, 1e-9, 0) is not None
    stiffness.factor(positions @ TURN.T)
    found = stiffness.iterate(positions @ TURN.T, right_side, 1e-9, 0)
    assert found is not None
    np.testing.assert_allclose(
        found, stiffness.solve_by_new_factor(positions @ TURN.T, right_side), rtol=1e-6
    )


def test_a_body_that_sags_on_takes_fewer_iterations(monkeypatch) -> None:
    body = hanging_beam(mesh=beam_mesh((12, 1, 1), (0.12, 0.01, 0.01)))
    stiffness = body.solver.stiffness
    first = body.solve_equilibrium(uniform_material(body.mesh, 300e3), GRAVITY).positions
    second = body.solve_equilibrium(uniform_material(body.mesh, 250e3), GRAVITY).positions
    body.prepare(uniform_material(body.mesh, 250e3), GRAVITY)
    side = np.linspace(1.0, 2.0, stiffness.pattern.size)

    def rounds() -> int:
        made: list[bool] = []
        product = stiffness.force_tangent
        with monkeypatch.context() as patch:
            patch.setattr(
                stiffness, 'force_tangent', lambda *given: (made.append(True), product(*given))[1]
            )
            assert stiffness.iterate(second, side, 1e-6, 200) is not None
        return len(made)

    stiffness.factor(first)
    turned = rounds()
    monkeypatch.setattr(TurnedFactor, 'turn_to', lambda *_: None)
    stiffness.factor(first)
    assert turned < 0.7 * rounds()


@pytest.mark.parametrize('element', list(Element))
def test_rotations_of_nodes(element) -> None:
    mesh = beam_mesh((3, 1, 2))
    body = StaticBody(mesh, element, held_end(mesh))
    # Stretched along askew axes first, then turned: the polar decomposition by its definition.
    axes = rotation_matrix(np.array([0.3, 0.5, -0.2]))
    stretch = axes @ np.diag([1.9, 0.6, 1.2]) @ axes.T
    found = NodeRotations(body.elastic).at(body.own_discretisation.rest_nodes @ stretch @ TURN.T)
    np.testing.assert_allclose(found, np.broadcast_to(TURN, found.shape), atol=1e-12)


def test_a_body_inside_out_is_not_turned() -> None:
    mesh = beam_mesh((2, 1, 1))
    body = StaticBody(mesh, Element.LINEAR, held_end(mesh))
    found = NodeRotations(body.elastic).at(-body.own_discretisation.rest_nodes)
    np.testing.assert_array_equal(found, np.broadcast_to(np.eye(3), found.shape))
