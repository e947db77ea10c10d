# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Both integrators: order, energy, agreement with each other, and the longest stable step."""

from dataclasses import replace

from diffcal_ros.damping import Damping
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.held_nodes import HeldNodes
from diffcal_ros.fem.motion.implicit import ImplicitIntegrator
from diffcal_ros.fem.motion.inputs import MotionInputs
from diffcal_ros.fem.motion.moving_body import MovingBody, TIME_STEP
from diffcal_ros.fem.motion.stable_step import stable_step
import numpy as np
import pytest
from support.beams import beam_mesh
from support.bodies import GRAVITY, hanging_beam, uniform_material
from support.moving_bodies import Case, directions, released_beam, shaken_beam

# The issue asks for slopes of 2 and 1 within this.
_SLOPE_ERROR = 0.1


@pytest.mark.parametrize(
    ('integrator', 'steps', 'order'),
    [
        ('implicit', (1 / 240, 1 / 480, 1 / 960), 2),
        ('semi_implicit', (1 / 4000, 1 / 8000, 1 / 16000), 1),
    ],
)
@pytest.mark.slow_but_first
def test_order_of_accuracy(integrator, steps, order) -> None:
    paths = [shaken_beam(integrator, step).run().positions for step in steps]
    coarse, fine = (np.linalg.norm(paths[i] - paths[i + 1]) for i in (0, 1))
    assert abs(np.log2(coarse / fine) - order) < _SLOPE_ERROR


@pytest.mark.slow
def test_integrators_agree_in_the_limit_of_small_steps(random) -> None:
    coarse, fine, implicit = (
        released_beam(
            Element.LINEAR,
            np.random.default_rng(1),
            integrator=integrator,
            time_step=time_step,
            counts=(4, 1, 1),
        )
        for integrator, time_step in (
            ('semi_implicit', 1 / 20000),
            ('semi_implicit', 1 / 40000),
            ('implicit', 1 / 2000),
        )
    )
    paths = [case.run().positions for case in (coarse, fine, implicit)]
    # Semi-implicit Euler errs in proportion to its step: twice the finer less the coarser is the
    # limit.
    np.testing.assert_allclose(2.0 * paths[1] - paths[0], paths[2], atol=2e-5)
    by_positions = np.zeros_like(paths[0])
    by_positions[-1, -1] = 0.3, 1.0, -2.0
    gradients = [case.body.gradient(by_positions) for case in (coarse, fine, implicit)]
    for name, change in directions(implicit, random).items():
        first, second, expected = (gradient.along(change) for gradient in gradients)
        assert 2.0 * second - first == pytest.approx(expected, rel=1e-2), name


def test_semi_implicit_derivatives(random) -> None:
    case = released_beam(Element.QUADRATIC, random, integrator='semi_implicit', counts=(2, 1, 1))
    case = replace(case, stamps=np.array([0.01, 0.03, 0.05]))
    motion = case.run()
    changes = directions(case, random)
    by_positions = random.normal(size=motion.positions.shape)
    gradient = case.body.gradient(by_positions)
    tangents = case.body.tangents(list(changes.values()))
    for (name, change), tangent in zip(changes.items(), tangents, strict=True):
        forward = float((tangent * by_positions).sum())
        assert gradient.along(change) == pytest.approx(forward, rel=1e-7), name
        errors = []
        for step in (4e-4, 2e-4, 1e-4):
            ahead = case.moved(change, step).run().positions
            behind = case.moved(change, -step).run().positions
            difference = (ahead - behind) / (2.0 * step)
            errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
        assert min(errors) < 1e-5, (name, errors)


def test_checkpoints_do_not_change_the_gradient(random) -> None:
    def case(checkpoint_bytes: int) -> Case:
        built = released_beam(
            Element.LINEAR, np.random.default_rng(2), integrator='semi_implicit', counts=(2, 1, 1)
        )
        body = MovingBody(
            built.body.static_body,
            built.body.release,
            integrator='semi_implicit',
            checkpoint_bytes=checkpoint_bytes,
        )
        return replace(built, body=body)

    roomy, tight = case(64_000_000), case(22 * 2 * 18 * 24)
    by_positions = random.normal(size=roomy.run().positions.shape)
    tight.run()
    expected = roomy.body.gradient(by_positions)
    found = tight.body.gradient(by_positions)
    np.testing.assert_array_equal(found.youngs_modulus, expected.youngs_modulus)
    np.testing.assert_array_equal(found.damping, expected.damping)


def test_longest_stable_step(random) -> None:
    case = released_beam(Element.LINEAR, random, counts=(2, 1, 1))
    dynamics = Dynamics(case.body.static_body)
    dynamics.take(MotionInputs(case.material, case.damping, GRAVITY))
    rest = case.body.static_body.discretisation.rest_nodes
    still, free = np.zeros_like(rest), dynamics.free
    size = 3 * len(free)
    stiffness, damping = np.zeros((size, size)), np.zeros((size, size))
    for column in range(size):
        field = np.zeros_like(rest)
        field[free[column // 3], column % 3] = 1.0
        stiffness[:, column] = dynamics.force_tangent(rest, still, field, still)[free].ravel()
        damping[:, column] = dynamics.velocity_tangents(rest, still, field[None])[0][free].ravel()
    inverse = 1.0 / np.repeat(dynamics.masses[free, 0], 3)

    def largest_root(step: float) -> float:
        forward = np.eye(2 * size)
        forward[size:, :size] = -step * inverse[:, None] * stiffness
        forward[size:, size:] -= step * inverse[:, None] * damping
        forward[:size, size:] = step * np.eye(size)
        forward[:size] += step * (forward[size:] - np.eye(2 * size)[size:])
        return float(np.abs(np.linalg.eigvals(forward)).max())

    longest = stable_step(dynamics, rest)
    assert largest_root(longest) < 1.0 + 1e-9
    # The estimate keeps 0.7 of what it finds: twice as much is beyond the bound.
    assert largest_root(2.0 * longest) > 1.1


@pytest.mark.parametrize('element', list(Element))
def test_an_undamped_swing_keeps_its_energy(element) -> None:
    mesh = beam_mesh((4, 1, 1))
    static = hanging_beam(element, mesh)
    material = uniform_material(mesh, 60e3, 0.45)
    # It starts where a fifth of its weight would hold it, so that slow modes alone swing.
    start = static.solve_equilibrium(material, 0.2 * GRAVITY).positions
    rest = static.solve_equilibrium(material, GRAVITY).positions
    dynamics = Dynamics(static)
    dynamics.take(MotionInputs(material, Damping(np.zeros(mesh.tet_count)), GRAVITY))
    integrator = ImplicitIntegrator(dynamics, TIME_STEP)
    frames = integrator.march(
        start, np.array([0.5, 1.0, 2.0]), HeldNodes(static, None, np.zeros(6)).at
    )

    def energy(positions: np.ndarray, velocities: np.ndarray) -> float:
        kinetic = 0.5 * float((dynamics.masses * velocities**2).sum())
        moved = positions - static.discretisation.rest_nodes
        return kinetic + static.elastic.energy(positions) - float((dynamics.loads * moved).sum())

    begun, lowest = (energy(positions, np.zeros_like(rest)) for positions in (start, rest))
    for positions, velocities in zip(frames.frames, frames.rates, strict=True):
        loss = (begun - energy(positions, velocities)) / (begun - lowest)
        # The issue asks for at most 1 % over 2 s; a gain could only come from a mistake.
        assert -1e-3 < loss < 0.01
