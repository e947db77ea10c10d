# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fibres along one direction: derivatives, moduli along and across, turns, absence bit for bit."""

from diffcal_ros.effects.anisotropy import Fibres, FibreTerm
from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.sparse_pattern import make_pattern
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, uniform_material

DIRECTION = np.array([0.8, -0.36, 0.48])
MODULUS, NU, SIZE = 50e3, 0.3, (0.04, 0.03, 0.02)


def fibres_of(ratio: float, direction: np.ndarray = DIRECTION) -> Conditions:
    return Conditions(potentials=(Fibres(ratio, direction),))


def fibres(element: Element, random) -> tuple[FibreTerm, np.ndarray, object]:
    mesh = beam_mesh((3, 2, 2), SIZE)
    shape = discretise(mesh, element)
    pattern = make_pattern(shape, held_end(mesh))
    term = FibreTerm(shape, pattern, 'cpu', DIRECTION)
    term.take(Fibres(1.7, DIRECTION), random.uniform(1e4, 2e4, size=mesh.tet_count))
    return term, shape.rest_nodes + random.normal(scale=8e-4, size=shape.rest_nodes.shape), pattern


@pytest.mark.parametrize('element', Element)
def test_forces_and_stiffness_are_derivatives(element, random) -> None:
    term, positions, pattern = fibres(element, random)
    direction = np.zeros_like(positions)
    direction[pattern.free_nodes] = random.normal(size=(len(pattern.free_nodes), 3))
    forces, pushed = term.forces(positions), term.force_tangent(positions, direction)
    by_energy, by_force = [], []
    for step in (1e-6, 1e-7, 1e-8):
        ahead, behind = positions + step * direction, positions - step * direction
        work = (term.energy(ahead) - term.energy(behind)) / (2.0 * step)
        by_energy.append(abs(work / float((forces * direction).sum()) - 1.0))
        change = (term.forces(ahead) - term.forces(behind)) / (2.0 * step)
        by_force.append(np.linalg.norm(change - pushed) / np.linalg.norm(pushed))
    assert min(by_energy) < 1e-6
    assert min(by_force) < 1e-6
    lower = np.zeros((pattern.size, pattern.size))
    columns = np.repeat(np.arange(pattern.size), np.diff(pattern.column_starts))
    lower[pattern.row_indices, columns] = term.stiffness(positions, is_guarded=False)
    whole = lower + np.tril(lower, -1).T
    found = whole @ direction[pattern.free_nodes].ravel()
    np.testing.assert_allclose(
        found, pushed[pattern.free_nodes].ravel(), atol=1e-10 * np.abs(found).max()
    )
    guarded = term.stiffness(positions, is_guarded=True)
    lower[pattern.row_indices, columns] = guarded
    assert np.linalg.eigvalsh(lower + np.tril(lower, -1).T).min() > -1e-9 * np.abs(guarded).max()


@pytest.mark.parametrize('element', Element)
def test_small_pull_along_the_fibres_meets_their_stiffness(element) -> None:
    """psi'' by a uniform strain is ratio G along d, and nothing for one across it."""
    mesh = beam_mesh((3, 2, 2), SIZE)
    shape = discretise(mesh, element)
    term = FibreTerm(shape, make_pattern(shape, held_end(mesh)), 'cpu', DIRECTION)
    term.take(Fibres(1.5, DIRECTION), np.full(mesh.tet_count, 2e4))
    volume, strain = mesh.volumes.sum(), 1e-4
    across = np.cross(DIRECTION, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    for axis, expected in ((DIRECTION, 0.5 * 1.5 * 2e4 * strain**2 * volume), (across, 0.0)):
        pulled = shape.rest_nodes + strain * np.outer(shape.rest_nodes @ axis, axis)
        # (1 + e)^2 - 1 = 2 e (1 + e/2)
        assert term.energy(pulled) == pytest.approx(expected, rel=2.0 * strain, abs=1e-18)


def test_rigid_turns_cost_nothing(random) -> None:
    term, _, _ = fibres(Element.LINEAR, random)
    nodes = beam_mesh((3, 2, 2), SIZE).rest_positions
    turned = nodes @ rotation_matrix(np.array([0.4, -1.1, 0.7])).T + 0.02
    assert term.energy(turned) < 1e-25
    assert np.abs(term.forces(turned)).max() < 1e-12


def body() -> StaticBody:
    mesh = beam_mesh()
    return StaticBody(mesh, Element.QUADRATIC, held_end(mesh))


def test_fibres_along_a_beam_stiffen_its_bending_and_fibres_across_hardly() -> None:
    """E along grows by ratio G: sag falls by E / (E + ratio G)."""
    own, ratio = body(), 3.0
    material = uniform_material(own.mesh, 200e3, nu=NU)
    down = np.array([0.0, 0.0, -9.8])

    def sag(conditions: Conditions) -> float:
        moved = own.solve_equilibrium(material, down, conditions=conditions).positions
        return float(-(moved - own.discretisation.rest_nodes)[:, 2].min())

    plain = sag(Conditions())
    shear = 200e3 / (2.0 * (1.0 + NU))
    along = sag(fibres_of(ratio, np.eye(3)[0]))
    assert along / plain == pytest.approx(200e3 / (200e3 + ratio * shear), rel=0.06)
    across = sag(fibres_of(ratio, np.eye(3)[1]))
    assert 0.9 < across / plain <= 1.0


def _settled(own, ratio: float, by_ratio: float = 0.0, by_modulus: float = 0.0) -> np.ndarray:
    conditions = fibres_of(ratio + by_ratio)
    material = uniform_material(own.mesh, 30e3 * np.exp(by_modulus))
    return own.solve_equilibrium(material, GRAVITY, conditions=conditions).positions


def _changes(own) -> dict[str, Change]:
    return {
        'by_ratio': Change(conditions=fibres_of(1.0)),
        'by_modulus': Change(youngs_modulus=np.full(own.mesh.tet_count, 30e3)),
    }


@pytest.mark.parametrize('ratio', [0.0, 2.0])
def test_equilibrium_follows_the_ratio_and_the_modulus(ratio) -> None:
    own = body()
    for name, change in _changes(own).items():
        _settled(own, ratio)
        tangent = own.tangents([change])[0]
        weights = np.random.default_rng(1).normal(size=tangent.shape)
        by_adjoint = own.gradient(weights).along(change)
        assert by_adjoint == pytest.approx(float((weights * tangent).sum()), rel=1e-6)
        errors = []
        for step in (4e-3, 2e-3, 1e-3):
            # Negative ratios are small here: what stays of the isotropic energy holds the body.
            difference = _settled(own, ratio, **{name: step}) - _settled(
                own, ratio, **{name: -step}
            )
            difference /= 2.0 * step
            errors.append(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))
        assert errors[-1] < 1e-3, (name, errors)
        # Below this, it is what the equilibrium leaves of the force.
        assert errors[-1] < 0.5 * errors[0] or max(errors) < 5e-5, (name, errors)


def test_no_fibres_are_the_same_model_bit_for_bit() -> None:
    plain, given = body(), body()
    material = uniform_material(plain.mesh)
    without = plain.solve_equilibrium(material, GRAVITY).positions
    turned = fibres_of(0.0)
    np.testing.assert_array_equal(
        given.solve_equilibrium(material, GRAVITY, conditions=turned).positions, without
    )
