# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Old factorisations that turn with the body, and when a new one pays."""

from dataclasses import replace

from diffcal_ros.damping import Damping
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import linear_elastic, stable_neo_hookean
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.inputs import MotionInputs
from diffcal_ros.fem.motion.node_rotations import NodeRotations
from diffcal_ros.fem.motion.step_system import StepSystem
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import NO_CONDITIONS
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
import pytest
from scipy.sparse import csc_array
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, uniform_material

RULE = StepRule(1 / 240, 0.8)
TURN = rotation_matrix(np.array([0.4, -1.0, 2.0]))


def _dynamics(law, random) -> tuple[Dynamics, np.ndarray]:
    """A damped body, and positions at which it is bent and stretched."""
    mesh = beam_mesh((3, 1, 2))
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh), law=law)
    dynamics = Dynamics(body)
    damping = Damping(20.0 * (1.0 + random.random(mesh.tet_count)))
    material = replace(uniform_material(mesh), conversion=law.CONVERSION)
    dynamics.take(MotionInputs(material, damping, GRAVITY, NO_CONDITIONS))
    rest = body.discretisation.rest_nodes
    return dynamics, rest + 5e-5 * random.normal(size=rest.shape)


def test_a_turned_factorisation_is_that_of_the_turned_body(random) -> None:
    dynamics, positions = _dynamics(stable_neo_hookean, random)
    forces = random.normal(size=3 * len(dynamics.free))
    old, new = StepSystem(dynamics), StepSystem(dynamics)
    new.factor(RULE, positions @ TURN.T)
    old.factor(RULE, positions)
    unturned = old.apply(forces)
    old.turn(positions @ TURN.T)
    expected = new.apply(forces)
    np.testing.assert_allclose(old.apply(forces), expected, atol=1e-9 * np.abs(expected).max())
    assert np.abs(unturned - expected).max() > 0.1 * np.abs(expected).max()


def test_a_law_that_feels_turns_keeps_its_factorisation(random) -> None:
    dynamics, positions = _dynamics(linear_elastic, random)
    dynamics.elements.set_damping(np.zeros(dynamics.body.mesh.tet_count))
    forces = random.normal(size=3 * len(dynamics.free))
    system = StepSystem(dynamics)
    system.factor(RULE, positions)
    before = system.apply(forces)
    system.turn(positions @ TURN.T)
    np.testing.assert_array_equal(system.apply(forces), before)
    system.factor(RULE, positions @ TURN.T)
    np.testing.assert_allclose(system.apply(forces), before, rtol=1e-6)


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


def test_a_factorisation_wears_out_when_rounds_cost_more_than_a_new_one(random) -> None:
    dynamics, positions = _dynamics(stable_neo_hookean, random)
    system = StepSystem(dynamics)
    system.factor(RULE, positions)
    assert not system.is_worn
    # With the 12 rounds that a factorisation takes: 17, 11, 9, 8.5 and 8.6 a step on average.
    states = []
    for rounds in (5, 5, 5, 7, 9):
        system.note(rounds)
        states.append(system.is_worn)
    assert states == [False, False, False, False, True]
    system.factor(RULE, positions)
    assert not system.is_worn


def test_many_sides_are_solved_for_as_one_is(random) -> None:
    mesh = beam_mesh((5, 2, 1))
    dynamics = Dynamics(StaticBody(mesh, Element.QUADRATIC, held_end(mesh), solver='qdldl'))
    damping = Damping(np.full(mesh.tet_count, 60.0))
    dynamics.take(MotionInputs(uniform_material(mesh), damping, GRAVITY, NO_CONDITIONS))
    rest = dynamics.body.discretisation.rest_nodes
    state = StepState(rest, 0.02 * random.normal(size=rest.shape), np.zeros(rest.shape), rest)
    sides = random.normal(size=(5, *rest.shape)) * 10.0 ** -np.arange(5.0)[:, None, None]
    sides[:, dynamics.body.held_nodes] = 0.0
    system = StepSystem(dynamics)
    system.factor_for(len(sides), RULE, rest)
    found = system.solve(state, sides, is_transposed=False)
    system.factor_for(1, RULE, rest)
    for side, own in zip(sides, found, strict=True):
        alone = system.solve(state, side[None], is_transposed=False)[0]
        np.testing.assert_allclose(own, alone, atol=1e-7 * np.abs(alone).max())
    assert not system.is_ready(RULE)


def _step_matrix(dynamics: Dynamics, state: StepState) -> np.ndarray:
    """What a step's matrix is on free nodes, from its parts; shape (3 M, 3 M)."""
    pattern, free = dynamics.pattern, dynamics.free
    values = dynamics.system_values(state.positions, RULE.inertia, RULE.rate)
    shape = (pattern.size, pattern.size)
    lower = csc_array((values, pattern.row_indices, pattern.column_starts), shape).toarray()
    each = np.zeros((pattern.size, *state.positions.shape))
    each[:, free] = np.eye(pattern.size).reshape(pattern.size, -1, 3)
    place = state.positions, state.velocities
    left = dynamics.rest_product(*place, each, RULE.rate, is_transposed=False)
    return lower + np.tril(lower, -1).T + left[:, free].reshape(pattern.size, -1).T


@pytest.mark.parametrize('is_transposed', [False, True])
@pytest.mark.parametrize('speed', [0.05, 60.0])
def test_a_step_is_solved_however_much_damping_outweighs(random, speed, is_transposed) -> None:
    mesh = beam_mesh((3, 1, 2))
    dynamics = Dynamics(StaticBody(mesh, Element.LINEAR, held_end(mesh)))
    damping = Damping(2000.0 * (1.0 + random.random(mesh.tet_count)))
    dynamics.take(MotionInputs(uniform_material(mesh), damping, GRAVITY, NO_CONDITIONS))
    rest = dynamics.body.discretisation.rest_nodes
    velocities = speed * random.normal(size=rest.shape)
    state = StepState(rest, velocities, np.zeros(rest.shape), rest)
    sides = random.normal(size=(3, *rest.shape)) * np.array([1.0, 0.0, 1e-6])[:, None, None]
    sides[:, dynamics.body.held_nodes] = 0.0
    system = StepSystem(dynamics)
    system.factor_for(len(sides), RULE, rest)
    found = system.solve(state, sides, is_transposed=is_transposed)
    matrix = _step_matrix(dynamics, state)
    given = sides[:, dynamics.free].reshape(len(sides), -1)
    expected = np.linalg.solve(matrix.T if is_transposed else matrix, given.T).T
    solved = found[:, dynamics.free].reshape(len(sides), -1)
    for one, by_matrix in zip(solved, expected, strict=True):
        np.testing.assert_allclose(one, by_matrix, atol=1e-6 * np.abs(by_matrix).max())
    assert not found[:, dynamics.body.held_nodes].any()
    # Rounds settle the first speed and grow at the second.
    factored = _step_matrix(dynamics, replace(state, velocities=np.zeros_like(rest)))
    inverse = np.linalg.inv(factored)
    spread = np.abs(np.linalg.eigvals(inverse @ matrix - np.eye(len(matrix)))).max()
    assert (spread > 1.0) == (speed > 1.0)
