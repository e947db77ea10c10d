# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Every law: energy, force and stiffness by differences; Hooke's law; pulled bars."""

from functools import partial

from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.sparse_pattern import make_pattern
from diffcal_ros.fem.laws import find_law, law_names
from diffcal_ros.fem.laws.mooney_rivlin import RATIO
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import lame_lambda, lame_mu, LameParameters, Material
import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.sparse import csc_matrix, tril
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY

LAWS = law_names()
OTHERS = LAWS[1:]  # Those of the usual law have tests of their own with both elements.
STEPS = (1e-5, 3e-6, 1e-6)  # [m], of meshes of 1 cm and random displacements of 1 mm
# Central differences of step h err by h^2 times the third derivative: below this at all three.
_RELATIVE = 2e-4
# A stretch of 1e-6 leaves terms of that order beside Hooke's law.
_SMALL, _OF_SMALL = 1e-6, 1e-4
_SIZE = (0.04, 0.02, 0.02)


def _material(mesh, law: str, modulus: float = 80e3, nu: float = 0.4) -> Material:
    ones = np.ones(mesh.tet_count)
    return Material(modulus * ones, nu * ones, 1e3 * ones, conversion=find_law(law).CONVERSION)


def _shaken(law: str, random: np.random.Generator) -> tuple[ElasticBody, np.ndarray]:
    mesh = beam_mesh((3, 1, 2), (0.05, 0.02, 0.03))
    body = ElasticBody(discretise(mesh, Element.QUADRATIC), law=find_law(law))
    mu = 4e4 * (1.0 + random.random(mesh.tet_count))
    body.set_lame_parameters(LameParameters(mu, 30.0 * mu * (1.0 + random.random(mesh.tet_count))))
    rest = body.discretisation.rest_nodes
    return body, rest + 1e-3 * random.normal(size=rest.shape)


@pytest.mark.parametrize('law', OTHERS)
@pytest.mark.parametrize('step', STEPS)
def test_force_and_stiffness_are_slopes(law, step, random) -> None:
    body, positions = _shaken(law, random)
    direction = random.normal(size=positions.shape)
    above, below = positions + step * direction, positions - step * direction
    slope = (body.energy(above) - body.energy(below)) / (2.0 * step)
    assert slope == pytest.approx(float((body.forces(positions) * direction).sum()), rel=_RELATIVE)
    change = (body.forces(above) - body.forces(below)) / (2.0 * step)
    tangent = body.force_tangent(positions, direction)
    assert np.linalg.norm(change - tangent) < _RELATIVE * np.linalg.norm(tangent)


@pytest.mark.parametrize('law', OTHERS)
def test_assembled_stiffness_agrees_with_the_matrix_free_product(law, random) -> None:
    body, positions = _shaken(law, random)
    held = held_end(beam_mesh((3, 1, 2), (0.05, 0.02, 0.03)))
    pattern = make_pattern(body.discretisation, held)
    values = body.make_stiffness(pattern).values(positions)
    shape = (pattern.size, pattern.size)
    lower = csc_matrix((values, pattern.row_indices, pattern.column_starts), shape=shape)
    direction = random.normal(size=positions.shape)
    direction[held] = 0.0
    expected = body.force_tangent(positions, direction)[pattern.free_nodes].ravel()
    product = (lower + tril(lower, -1).T) @ direction[pattern.free_nodes].ravel()
    np.testing.assert_allclose(product, expected, rtol=1e-10, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize('law', OTHERS)
def test_constants_pull_forces_and_are_pulled_back(law, random) -> None:
    body, positions = _shaken(law, random)
    count = len(body.discretisation.nodes)
    change = LameParameters(random.normal(size=count), random.normal(size=count))
    tangent = body.force_of_lame_parameters(positions, change)
    adjoint = random.normal(size=positions.shape)
    by = body.number_gradient(positions, adjoint)
    pulled = by.neo_hookean_mu @ change.neo_hookean_mu
    pulled += by.neo_hookean_lambda @ change.neo_hookean_lambda
    assert pulled == pytest.approx(float((adjoint * tangent).sum()), rel=1e-9)
    # Laws are linear in their constants: the force of the constants themselves is the force.
    everything = LameParameters(body._mu.numpy(), body._lam.numpy())
    forces = body.forces(positions)
    np.testing.assert_allclose(
        body.force_of_lame_parameters(positions, everything),
        forces,
        atol=1e-9 * np.abs(forces).max(),
    )


@pytest.mark.parametrize('law', LAWS)
def test_small_strains_follow_hookes_law_with_e_and_nu(law, random) -> None:
    mesh = beam_mesh((2, 1, 1), _SIZE)
    material = _material(mesh, law)
    body = ElasticBody(discretise(mesh, Element.LINEAR), law=find_law(law))
    body.set_lame_parameters(material.lame_parameters())
    half = random.normal(size=(3, 3))
    strain = half + half.T  # Askew: every component counts.
    found = _stress(body, np.eye(3) + _SMALL * strain)
    mu = lame_mu(material.youngs_modulus, material.poissons_ratio)[0]
    lam = lame_lambda(material.youngs_modulus, material.poissons_ratio)[0]
    hooke = _SMALL * (2.0 * mu * strain + lam * np.trace(strain) * np.eye(3))
    np.testing.assert_allclose(found, hooke, atol=_OF_SMALL * np.abs(hooke).max())


@pytest.mark.parametrize('law', [law for law in LAWS if law != 'linear_elastic'])
def test_turning_a_body_turns_its_forces(law, random) -> None:
    body, positions = _shaken(law, random)
    rotation = np.linalg.qr(random.normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    np.testing.assert_allclose(
        body.forces(positions @ rotation.T), body.forces(positions) @ rotation.T, atol=1e-9
    )


def test_linear_elasticity_takes_a_turn_for_a_stretch(random) -> None:
    body, _ = _shaken('linear_elastic', random)
    angle = 0.3
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0, 0, 1.0]]
    )
    mu, lam = body._mu.numpy(), body._lam.numpy()
    loss = 1.0 - np.cos(angle)  # The strain is diag(-loss, -loss, 0).
    density = 2.0 * mu * loss**2 + 2.0 * lam * loss**2
    volumes = body.discretisation.weights.sum(axis=1)
    turned = body.discretisation.rest_nodes @ turn.T
    assert body.energy(turned) == pytest.approx(float(density @ volumes), rel=1e-9)


def _stress(body: ElasticBody, gradient: np.ndarray) -> np.ndarray:
    """First Piola-Kirchhoff stress of a uniform deformation, from nodal forces [Pa]."""
    rest = body.discretisation.rest_nodes
    forces = body.forces(rest @ gradient.T)
    # The virial: forces times rest positions over the volume.
    return forces.T @ rest / body.discretisation.weights.sum()


def _neo_hookean(mu, kappa, a, b, c):
    trace = a * a + b * b + c * c
    shear = mu * (1.0 - 1.0 / (trace + 1.0))
    return shear * a + (kappa * (a * b * c - 1.0) - 0.75 * mu) * b * c


def _mooney_rivlin(mu, kappa, a, b, c):
    first, second = mu / (1.0 + RATIO), mu * RATIO / (1.0 + RATIO)  # 2 C10 and 2 C01
    pressure = kappa * (a * b * c - 1.0) - first - 2.0 * second
    return first * a + second * a * (b * b + c * c) + pressure * b * c


def _st_venant(mu, lam, a, b, c):
    strains = 0.5 * (np.array([a, b, c]) ** 2 - 1.0)
    return a * (2.0 * mu * strains[0] + lam * strains.sum())


def _hooke(mu, lam, a, b, c):
    return 2.0 * mu * (a - 1.0) + lam * (a + b + c - 3.0)


@pytest.mark.parametrize('stretch', [0.8, 1.25])
@pytest.mark.parametrize(
    ('law', 'principal'),
    [
        ('stable_neo_hookean', _neo_hookean),
        ('mooney_rivlin', _mooney_rivlin),
        ('st_venant_kirchhoff', _st_venant),
        ('linear_elastic', _hooke),
    ],
)
def test_a_pulled_bar_meets_the_closed_form(law, principal, stretch) -> None:
    """Principal stresses by hand, sides free of stress, beside an equilibrium."""
    mesh = beam_mesh((2, 1, 1), _SIZE)
    material = _material(mesh, law)
    numbers = material.lame_parameters()
    closed = partial(principal, numbers.neo_hookean_mu[0], numbers.neo_hookean_lambda[0])
    side = brentq(lambda b: closed(b, b, stretch), 0.7, 1.3, xtol=1e-14)
    body = ElasticBody(discretise(mesh, Element.LINEAR), law=find_law(law))
    body.set_lame_parameters(numbers)
    found = _stress(body, np.diag([stretch, side, side]))
    pull = closed(stretch, side, side)
    np.testing.assert_allclose(found, np.diag([pull, 0.0, 0.0]), atol=1e-9 * abs(pull))


def test_mooney_rivlin_of_an_incompressible_bar() -> None:
    # Textbook: P = 2 (stretch - 1/stretch^2) (C10 + C01 / stretch); kappa large.
    stretch, mu = 1.4, 3e4
    c10, c01 = mu / (2.0 * (1.0 + RATIO)), mu * RATIO / (2.0 * (1.0 + RATIO))
    closed = partial(_mooney_rivlin, mu, 1e6 * mu)
    side = brentq(lambda b: closed(b, b, stretch), 0.7, 1.0, xtol=1e-16)
    textbook = 2.0 * (stretch - stretch**-2) * (c10 + c01 / stretch)
    assert closed(stretch, side, side) == pytest.approx(textbook, rel=1e-5)


@pytest.mark.parametrize('law', OTHERS)
def test_a_hanging_beam_has_a_gradient(law) -> None:
    mesh = beam_mesh((6, 1, 1))
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh), law=find_law(law))
    weights = np.random.default_rng(4).normal(size=(body.discretisation.node_count, 3))
    values = []
    for modulus in (60e3 * (1 + 1e-4), 60e3 * (1 - 1e-4), 60e3):
        state = body.solve_equilibrium(_material(mesh, law, modulus, 0.45), GRAVITY)
        values.append(float((weights * state.positions).sum()))
    slope = (values[0] - values[1]) / (2e-4 * 60e3)
    found = body.gradient(weights).youngs_modulus.sum()
    # Equilibria are found to a force of 1e-7 of the load: the difference is good to about 1e-4.
    assert found == pytest.approx(slope, rel=1e-3)


def test_linear_elasticity_doubles_the_sag_with_the_load() -> None:
    mesh = beam_mesh((6, 1, 1))
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh), law=find_law('linear_elastic'))
    rest = body.discretisation.rest_nodes
    material = _material(mesh, 'linear_elastic', 30e3, 0.45)
    once = body.solve_equilibrium(material, GRAVITY).positions - rest
    twice = body.solve_equilibrium(material, 2.0 * GRAVITY).positions - rest
    np.testing.assert_allclose(twice, 2.0 * once, atol=1e-6 * np.abs(once).max())


def test_a_material_of_another_law_is_refused() -> None:
    mesh = beam_mesh((2, 1, 1), _SIZE)
    body = StaticBody(mesh, Element.LINEAR, held_end(mesh), law=find_law('mooney_rivlin'))
    with pytest.raises(ValueError, match='give the material the CONVERSION of its law'):
        body.solve_equilibrium(_material(mesh, 'linear_elastic'), GRAVITY)


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(ValueError, match="law is 'ogden': use one of stable_neo_hookean, linear"):
        find_law('ogden')
