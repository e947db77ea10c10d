# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Energy to force to stiffness to parameter derivatives, each by differences of the one before."""

from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.sparse_pattern import make_pattern
from diffcal_ros.fem.laws import find_law, law_names
from diffcal_ros.material import LameConvention, LameParameters, Material
import numpy as np
import pytest
from scipy.sparse import csc_matrix, tril
from support.beams import beam_mesh, held_end

ELEMENTS = list(Element)
STEPS = (1e-5, 3e-6, 1e-6)  # [m], of meshes of 1 cm and random displacements of 1 mm
# Central differences of step h err by h^2 times the third derivative: below this at all three.
_RELATIVE = 2e-4


def _body(element: Element, random: np.random.Generator) -> tuple[ElasticBody, np.ndarray]:
    body = ElasticBody(discretise(beam_mesh((3, 1, 2), (0.05, 0.02, 0.03)), element))
    tet_count = len(body.discretisation.nodes)
    mu = 4e4 * (1.0 + random.random(tet_count))
    body.set_lame_parameters(LameParameters(mu, 30.0 * mu * (1.0 + random.random(tet_count))))
    return body, body.discretisation.rest_nodes + 1e-3 * random.normal(
        size=body.discretisation.rest_nodes.shape
    )


@pytest.mark.parametrize('element', ELEMENTS)
@pytest.mark.parametrize('step', STEPS)
def test_force_is_the_slope_of_the_energy(element, step, random) -> None:
    body, positions = _body(element, random)
    direction = random.normal(size=positions.shape)
    rise = body.energy(positions + step * direction) - body.energy(positions - step * direction)
    slope = float((body.forces(positions) * direction).sum())
    assert rise / (2.0 * step) == pytest.approx(slope, rel=_RELATIVE)


@pytest.mark.parametrize('element', ELEMENTS)
@pytest.mark.parametrize('step', STEPS)
def test_force_tangent_is_the_slope_of_the_force(element, step, random) -> None:
    body, positions = _body(element, random)
    direction = random.normal(size=positions.shape)
    change = body.forces(positions + step * direction) - body.forces(positions - step * direction)
    tangent = body.force_tangent(positions, direction)
    error = np.linalg.norm(change / (2.0 * step) - tangent) / np.linalg.norm(tangent)
    assert error < _RELATIVE


@pytest.mark.parametrize('element', ELEMENTS)
def test_assembled_stiffness_agrees_with_the_matrix_free_product(element, random) -> None:
    body, positions = _body(element, random)
    held = held_end(beam_mesh((3, 1, 2), (0.05, 0.02, 0.03)))
    pattern = make_pattern(body.discretisation, held)
    values = body.make_stiffness(pattern).values(positions)
    shape = (pattern.size, pattern.size)
    lower = csc_matrix((values, pattern.row_indices, pattern.column_starts), shape=shape)
    matrix = lower + tril(lower, -1).T
    direction = random.normal(size=positions.shape)
    direction[held] = 0.0
    expected = body.force_tangent(positions, direction)[pattern.free_nodes].ravel()
    product = matrix @ direction[pattern.free_nodes].ravel()
    np.testing.assert_allclose(product, expected, rtol=1e-10, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize('element', ELEMENTS)
def test_diagonal_blocks_are_those_of_the_stiffness_at_rest(element, random) -> None:
    # At rest the guard changes nothing, so both are the plain stiffness.
    body, _ = _body(element, random)
    rest = body.discretisation.rest_nodes
    blocks = body.diagonal_blocks(rest)
    for node in (0, len(rest) // 2, len(rest) - 1):
        for axis in range(3):
            direction = np.zeros_like(rest)
            direction[node, axis] = 1.0
            column = body.force_tangent(rest, direction)[node]
            np.testing.assert_allclose(blocks[node, :, axis], column, rtol=1e-9)


@pytest.mark.parametrize('element', ELEMENTS)
def test_force_of_numbers_is_the_slope_by_the_material(element, random) -> None:
    body, positions = _body(element, random)
    count = len(body.discretisation.nodes)
    mu, lam = 4e4 * (1.0 + random.random(count)), 1e6 * (1.0 + random.random(count))
    dmu, dlam = random.normal(size=count), random.normal(size=count)
    body.set_lame_parameters(LameParameters(mu + dmu, lam + dlam))
    above = body.forces(positions)
    body.set_lame_parameters(LameParameters(mu - dmu, lam - dlam))
    below = body.forces(positions)
    body.set_lame_parameters(LameParameters(mu, lam))
    tangent = body.force_of_lame_parameters(positions, LameParameters(dmu, dlam))
    scale = np.abs(tangent).max()
    # The energy is linear in its numbers: the difference is exact up to rounding.
    np.testing.assert_allclose((above - below) / 2.0, tangent, atol=1e-7 * scale)
    adjoint = random.normal(size=positions.shape)
    by = body.number_gradient(positions, adjoint)
    pulled = by.neo_hookean_mu @ dmu + by.neo_hookean_lambda @ dlam
    assert pulled == pytest.approx(float((adjoint * tangent).sum()), rel=1e-9)


@pytest.mark.parametrize('element', ELEMENTS)
def test_turning_a_body_turns_its_forces(element, random) -> None:
    body, positions = _body(element, random)
    rotation = np.linalg.qr(random.normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    np.testing.assert_allclose(
        body.forces(positions @ rotation.T), body.forces(positions) @ rotation.T, atol=1e-10
    )
    assert body.energy(positions @ rotation.T) == pytest.approx(body.energy(positions))


@pytest.mark.parametrize('element', ELEMENTS)
def test_a_body_at_rest_has_no_energy_and_no_force(element, random) -> None:
    body, _ = _body(element, random)
    rest = body.discretisation.rest_nodes
    stiff = float(np.abs(body.force_tangent(rest, np.ones_like(rest) * rest)).max())
    assert body.energy(rest) == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(body.forces(rest), 0.0, atol=1e-10 * stiff)


def _uniaxial(material: Material, stretch: float) -> tuple[float, float]:
    """Force over area of a bar pulled by a small stretch, and its lateral contraction."""
    mesh = beam_mesh((2, 1, 1), (0.04, 0.02, 0.02))
    body = ElasticBody(discretise(mesh, Element.LINEAR))
    body.set_lame_parameters(material.lame_parameters())
    low, high = 0.0, 1.0
    for _ in range(60):  # the lateral strain at which the sides are free of force
        nu = 0.5 * (low + high)
        scale = np.array([1.0 + stretch, 1.0 - nu * stretch, 1.0 - nu * stretch])
        forces = body.forces(mesh.rest_positions * scale)
        side = forces[mesh.rest_positions[:, 1] == 0.0, 1].sum()
        low, high = (nu, high) if side < 0.0 else (low, nu)
    end = mesh.rest_positions[:, 0] == 0.04
    return float(forces[end, 0].sum()) / 0.02**2, nu


@pytest.mark.parametrize(
    ('convention', 'shear_share'),
    [(LameConvention.CONSISTENT, 1.0), (LameConvention.PAPER, 0.75)],
)
def test_small_stretch_measures_youngs_modulus(convention, shear_share) -> None:
    # Paper, plain Lame numbers: the shear stiffness at rest is 3/4 of mu, the bulk's is kept.
    modulus, nu, stretch = 80e3, 0.4, 1e-5
    mesh = beam_mesh((2, 1, 1), (0.04, 0.02, 0.02))
    count = mesh.tet_count
    material = Material(
        np.full(count, modulus), np.full(count, nu), np.full(count, 1000.0), convention
    )
    mu = shear_share * modulus / (2 * (1 + nu))
    numbers = material.lame_parameters()
    # Linearised at rest: shear 3/4 mu', Lame's other number lambda' - 5/8 mu' (see the energy).
    lam = float(numbers.neo_hookean_lambda[0]) - 0.625 * float(numbers.neo_hookean_mu[0])
    expected_modulus = mu * (3 * lam + 2 * mu) / (lam + mu)
    stress, contraction = _uniaxial(material, stretch)
    assert stress / stretch == pytest.approx(expected_modulus, rel=1e-3)
    assert contraction == pytest.approx(lam / (2 * (lam + mu)), rel=1e-3)
    # The paper's numbers measure another modulus than the one they are made from.
    is_kept = expected_modulus == pytest.approx(modulus, rel=1e-9)
    assert is_kept == (convention is LameConvention.CONSISTENT)


def _cofactors(body: ElasticBody, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return det F and its derivative by F, shapes (T, q) and (T, q, 3, 3)."""
    of = body.discretisation
    F = np.einsum('tai,tqaj->tqij', positions[of.nodes], of.gradients)
    volumes = np.linalg.det(F)
    return volumes, volumes[..., None, None] * np.linalg.inv(F).swapaxes(-1, -2)


def _forces_of(body: ElasticBody, stresses: np.ndarray) -> np.ndarray:
    of = body.discretisation
    forces = np.zeros_like(of.rest_nodes)
    at_nodes = np.einsum('tq,tqij,tqaj->tai', of.weights, stresses, of.gradients)
    np.add.at(forces, of.nodes, at_nodes)
    return forces


@pytest.mark.parametrize('name', law_names())
def test_a_law_says_whether_it_presses_by_volume(name, random) -> None:
    law = find_law(name)
    body = ElasticBody(discretise(beam_mesh((3, 1, 2)), Element.QUADRATIC), law=law)
    positions = body.discretisation.rest_nodes * np.array([1.1, 0.97, 1.05])
    positions += 1e-4 * random.normal(size=positions.shape)
    ones = np.ones(len(body.discretisation.nodes))
    force = body.force_of_lame_parameters(positions, LameParameters(0.0 * ones, ones))
    volumes, cofactors = _cofactors(body, positions)
    expected = _forces_of(body, (volumes - 1.0)[..., None, None] * cofactors)
    is_same = np.allclose(force, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
    assert is_same == getattr(law, 'PRESSES_BY_VOLUME', False)


@pytest.mark.parametrize('element', ELEMENTS)
@pytest.mark.parametrize('step', STEPS)
def test_stiffness_has_the_pressure_that_the_last_step_foresaw(element, step, random) -> None:
    body, positions = _body(element, random)
    lam = body.lame_parameters_on_device[1].numpy()
    pattern = make_pattern(body.discretisation, np.zeros(0, dtype=np.int32))
    stiffness = body.make_stiffness(pattern)
    without = stiffness.values(positions)
    last = 1e-3 * random.normal(size=positions.shape)
    stiffness.foresee(positions - last, last)
    more = stiffness.values(positions, is_foreseen=True) - without

    before, slope = _cofactors(body, positions - last)
    change = np.einsum(
        'tai,tqaj->tqij', last[body.discretisation.nodes], body.discretisation.gradients
    )
    foreseen = before + (slope * change).sum(axis=(2, 3))
    excess = lam[:, None] * (foreseen - _cofactors(body, positions)[0])
    direction = random.normal(size=positions.shape)
    ends = [_cofactors(body, positions + sign * step * direction)[1] for sign in (1.0, -1.0)]
    expected = _forces_of(body, excess[..., None, None] * (ends[0] - ends[1]) / (2.0 * step))
    found = pattern.times(more, direction.ravel()).reshape(-1, 3)
    np.testing.assert_allclose(found, expected, atol=_RELATIVE * np.abs(expected).max())
    stiffness.forget_step()
    np.testing.assert_array_equal(stiffness.values(positions, is_foreseen=True), without)
