# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Strain-rate damping: its power, what it leaves alone, and every derivative of it."""

from diffcal_ros.damping import Damping
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.elements.sparse_pattern import make_pattern
from diffcal_ros.fem.motion.moving_elements import MovingElements
import numpy as np
import pytest
from scipy.sparse import csr_matrix
from support.beams import beam_mesh
from support.bodies import hanging_beam, uniform_material

ELEMENTS = list(Element)
STEPS = (1e-2, 5e-3, 2.5e-3)
# Forces are cubic in positions and velocities: central differences err by the square of the step.
_SLOPE_ERROR = 0.2


class _Moving:
    """Elements, a state that is bent and stretched, and uneven damping."""

    def __init__(self, element: Element, random: np.random.Generator) -> None:
        mesh = beam_mesh((2, 1, 1), (0.04, 0.03, 0.02))
        self.body = hanging_beam(element, mesh)
        self.body.prepare(uniform_material(mesh), np.zeros(3))
        pattern = make_pattern(self.body.discretisation, np.zeros(0, dtype=np.int32))
        self.pattern = pattern
        self.elements = MovingElements(self.body.elastic, pattern)
        self.beta = 5.0 + 10.0 * random.random(mesh.tet_count)
        self.elements.set_damping(self.beta)
        rest = self.body.discretisation.rest_nodes
        self.positions = rest + 0.1 * rest[:, [1, 2, 0]] + 1e-3 * random.normal(size=rest.shape)
        self.velocities = random.normal(size=rest.shape)

    def gradients(self, field: np.ndarray) -> np.ndarray:
        discretisation = self.body.discretisation
        return np.einsum('tai,tqaj->tqij', field[discretisation.nodes], discretisation.gradients)

    def viscous(self, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        return self.elements.forces(positions, velocities) - self.body.elastic.forces(positions)


@pytest.fixture(params=ELEMENTS)
def moving(request, random) -> _Moving:
    return _Moving(request.param, random)


def test_power_is_twice_the_dissipation_potential(moving) -> None:
    deformation, rate = moving.gradients(moving.positions), moving.gradients(moving.velocities)
    turned = np.swapaxes(deformation, -1, -2) @ rate
    strain_rate = 0.5 * (turned + np.swapaxes(turned, -1, -2))
    weights = moving.body.discretisation.weights * moving.beta[:, None]
    potential = 0.5 * float((weights * (strain_rate**2).sum(axis=(2, 3))).sum())
    forces = moving.viscous(moving.positions, moving.velocities)
    assert float((forces * moving.velocities).sum()) == pytest.approx(2.0 * potential, rel=1e-10)


def test_a_rigid_motion_is_not_damped(moving) -> None:
    spin, speed = np.array([3.0, -5.0, 2.0]), np.array([0.3, 0.1, -0.7])
    rigid = np.cross(spin, moving.positions) + speed
    scale = np.abs(moving.viscous(moving.positions, moving.velocities)).max()
    assert np.abs(moving.viscous(moving.positions, rigid)).max() < 1e-10 * scale


def _slopes(forward, tangent: np.ndarray) -> list[float]:
    errors = []
    for step in STEPS:
        difference = (forward(step) - forward(-step)) / (2.0 * step)
        errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
    return errors


def test_tangent_by_positions_and_velocities(moving, random) -> None:
    moved = 1e-2 * random.normal(size=moving.positions.shape)
    sped = random.normal(size=moving.positions.shape)
    state = moving.positions, moving.velocities
    tangent = moving.elements.viscous_tangent(*state, moved, sped)
    by_speed = moving.elements.velocity_tangents(*state, np.stack([sped, moved]))
    for side, own in zip((sped, moved), by_speed, strict=True):
        alone = moving.elements.viscous_tangent(*state, np.zeros_like(side), side)
        np.testing.assert_allclose(own, alone, rtol=1e-10, atol=1e-12 * np.abs(alone).max())
    errors = _slopes(
        lambda step: moving.viscous(
            moving.positions + step * moved, moving.velocities + step * sped
        ),
        tangent,
    )
    slope = np.log2(errors[0] / errors[1])
    assert abs(slope - 2.0) < _SLOPE_ERROR or errors[0] < 1e-9, errors


def test_stiffness_and_what_it_leaves_out_make_the_tangent(moving, random) -> None:
    rate = 130.0
    state = moving.positions, moving.velocities
    direction, other = (random.normal(size=moving.positions.shape) for _ in range(2))
    values = moving.elements.stiffness(moving.positions, rate)
    pattern = moving.pattern
    upper = csr_matrix((values, pattern.row_indices, pattern.column_starts))
    full = upper + upper.T
    full.setdiag(upper.diagonal())
    product = (full @ direction.ravel()).reshape(-1, 3)
    sides = np.stack([direction, other])
    rest = moving.elements.rest_product(*state, sides, is_transposed=False)[0]
    tangent = moving.body.elastic.force_tangent(moving.positions, direction)
    tangent += moving.elements.viscous_tangent(*state, direction, rate * direction)
    np.testing.assert_allclose(product + rest, tangent, atol=1e-10 * np.abs(tangent).max())
    turned = moving.elements.rest_product(*state, sides, is_transposed=True)[1]
    forward, backward = float((other * rest).sum()), float((turned * direction).sum())
    assert backward == pytest.approx(forward, rel=1e-10)


def test_pull_back_is_the_transpose(moving, random) -> None:
    state = moving.positions, moving.velocities
    adjoint, moved, sped = (random.normal(size=moving.positions.shape) for _ in range(3))
    change = random.random(len(moving.beta))
    moving.elements.begin_sums()
    by_positions, by_velocities = moving.elements.pull_back(*state, adjoint, has_positions=True)
    tangent = moving.elements.viscous_tangent(*state, moved, sped)
    tangent += moving.body.elastic.force_tangent(moving.positions, moved)
    forward = float((adjoint * tangent).sum())
    backward = float((by_positions * moved).sum() + (by_velocities * sped).sum())
    assert backward == pytest.approx(forward, rel=1e-10)
    by_lame_parameters, by_beta = moving.elements.sums()
    force = moving.elements.force_of_damping(*state, change)
    assert float(by_beta @ change) == pytest.approx(float((adjoint * force).sum()), rel=1e-10)
    expected = moving.body.elastic.number_gradient(moving.positions, adjoint)
    np.testing.assert_allclose(
        by_lame_parameters.neo_hookean_mu, expected.neo_hookean_mu, rtol=1e-9
    )


@pytest.mark.parametrize(
    ('strain_rate', 'mass', 'message'),
    [(-1.0, 0.0, 'not negative in every'), (np.nan, 0.0, 'finite'), (1.0, -2.0, '-2 1/s')],
)
def test_senseless_damping_is_refused(strain_rate, mass, message) -> None:
    with pytest.raises(ValueError, match=message):
        Damping(np.array([1.0, strain_rate]), mass)
