# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tangents and adjoint of the equilibrium against differences, and against each other."""

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.material import Material
import numpy as np
import pytest
from support.bodies import GRAVITY, hanging_beam

ELEMENTS = list(Element)
# Equilibria are found to 1e-7 of the mean load; steps of 1e-3 leave that share of 1e-4, and their
# own second-order error is below 1e-5 of a beam that sags by a tenth of its length.
_RELATIVE = 3e-4
STEPS = (4e-3, 2e-3, 1e-3)


def _material(mesh, random) -> Material:
    count = mesh.tet_count
    return Material(
        youngs_modulus=40e3 * (1.0 + random.random(count)),
        poissons_ratio=0.40 + 0.05 * random.random(count),
        density=1000.0 * (1.0 + random.random(count)),
    )


def _changes(material: Material, random) -> dict[str, Change]:
    count = len(material.density)
    return {
        'youngs_modulus': Change(youngs_modulus=material.youngs_modulus * random.random(count)),
        'poissons_ratio': Change(poissons_ratio=0.1 * random.random(count)),
        'density': Change(density=material.density * random.random(count)),
        'gravity': Change(gravity=np.array([2.0, 1.0, -4.0])),
    }


def _moved(material: Material, change: Change, step: float) -> tuple[Material, np.ndarray]:
    def plus(values, direction):
        return values if direction is None else values + step * direction

    return (
        Material(
            plus(material.youngs_modulus, change.youngs_modulus),
            plus(material.poissons_ratio, change.poissons_ratio),
            plus(material.density, change.density),
        ),
        plus(GRAVITY, change.gravity),
    )


@pytest.mark.parametrize('element', ELEMENTS)
@pytest.mark.parametrize('name', ['youngs_modulus', 'poissons_ratio', 'density', 'gravity'])
@pytest.mark.parametrize('step', STEPS)
def test_tangents(element, name, step, random) -> None:
    body = hanging_beam(element)
    material = _material(body.mesh, random)
    change = _changes(material, random)[name]
    body.solve_equilibrium(material, GRAVITY)
    tangent = body.tangents([change])[0]
    above = body.solve_equilibrium(*_moved(material, change, step)).positions
    below = body.solve_equilibrium(*_moved(material, change, -step)).positions
    difference = (above - below) / (2.0 * step)
    error = np.linalg.norm(difference - tangent) / np.linalg.norm(tangent)
    # Central differences err by the square of the step.
    assert error < _RELATIVE + 50.0 * step**2


@pytest.mark.parametrize('element', ELEMENTS)
def test_adjoint_agrees_with_the_tangents(element, random) -> None:
    body = hanging_beam(element)
    material = _material(body.mesh, random)
    changes = _changes(material, random)
    state = body.solve_equilibrium(material, GRAVITY)
    by_positions = random.normal(size=state.positions.shape)
    gradient = body.gradient(by_positions)
    tangents = body.tangents(list(changes.values()))
    for change, tangent in zip(changes.values(), tangents, strict=True):
        forward = float((tangent * by_positions).sum())
        assert gradient.along(change) == pytest.approx(forward, rel=1e-8)


@pytest.mark.parametrize('element', ELEMENTS)
def test_derivatives_do_not_depend_on_how_the_state_was_reached(element, random) -> None:
    # After a warm start the factorisation is another state's: the solves must not show it.
    body = hanging_beam(element)
    material = _material(body.mesh, random)
    change = _changes(material, random)['youngs_modulus']
    body.solve_equilibrium(*_moved(material, change, 0.03))
    state = body.solve_equilibrium(material, GRAVITY)
    assert state.held_steps > 0
    warm = body.tangents([change])[0]
    body.forget()
    body.solve_equilibrium(material, GRAVITY)
    cold = body.tangents([change])[0]
    np.testing.assert_allclose(warm, cold, atol=2e-6 * np.abs(cold).max())


def test_equal_scaling_of_stiffness_and_density_changes_nothing(random) -> None:
    body = hanging_beam()
    material = _material(body.mesh, random)
    body.solve_equilibrium(material, GRAVITY)
    both = Change(youngs_modulus=material.youngs_modulus, density=material.density)
    only = Change(density=material.density)
    tangents = body.tangents([both, only])
    assert np.abs(tangents[0]).max() < 1e-7 * np.abs(tangents[1]).max()
