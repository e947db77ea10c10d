# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The slowest swing: against this package's own elements, and what other simulators make of it."""

from dataclasses import replace

from diffcal_ros.export.effective.simulators import find_simulator, find_swing
from diffcal_ros.export.first_mode import first_mode
from diffcal_ros.export.material_groups import material_groups
from diffcal_ros.export.targets.mjcf import time_step
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
import numpy as np
import pytest

LAW = find_law('st_venant_kirchhoff')
ROUNDS = 40
AMPLITUDE = 1e-4  # Of the tip [m]: forces follow displacements in proportion.


def own_mode(body):
    """Return frequency [1/s] and shape of the slowest swing by inverse iteration."""
    simulated = StaticBody(body.mesh, Element.LINEAR, body.held, law=LAW)
    material = Material(
        body.youngs_modulus, body.poissons_ratio, body.density, conversion=LAW.CONVERSION
    )
    simulated.solve_own_equilibrium(material, np.zeros(3))
    stiffness, rest = simulated.solver.stiffness, simulated.own_state.positions
    masses = body.vertex_masses[:, None]
    shape = np.tile([0.3, 1.0, 0.4], (body.mesh.vertex_count, 1))
    for _ in range(ROUNDS):
        (shape,) = stiffness.linear_solve(rest, (masses * shape)[None])
        shape /= np.abs(shape).max()
    square = (shape * stiffness.force_tangent(rest, shape)).sum() / (masses * shape**2).sum()
    return float(np.sqrt(square)), shape


@pytest.fixture
def weightless(body):
    """The body of two regions without gravity, damped alike everywhere."""
    factor = np.full(body.mesh.tet_count, 2e-3)
    return replace(body, gravity=np.zeros(3), damping=factor * body.damping_of_stiffness)


def test_frequency_and_gradients_are_those_of_this_packages_elements(body):
    frequency, shape = own_mode(body)
    mode = first_mode(body)
    assert mode.frequency == pytest.approx(frequency, rel=1e-6)
    corners = body.mesh.rest_positions[body.mesh.tets]
    sides = corners[:, 1:] - corners[:, :1]
    moved = shape[body.mesh.tets]
    wanted = np.swapaxes(np.linalg.solve(sides, moved[:, 1:] - moved[:, :1]), 1, 2)
    scale = (mode.gradients * wanted).sum() / (wanted**2).sum()
    np.testing.assert_allclose(
        mode.gradients, scale * wanted, atol=1e-4 * np.abs(mode.gradients).max()
    )


@pytest.mark.parametrize('name', ['mujoco', 'newton'])
def test_a_small_swing_dies_out_in_a_simulator_as_the_material_has_it(weightless, name):
    """By half the factor times the frequency squared, though MuJoCo's steps damp as well."""
    pytest.importorskip(name, reason=f'{name} is not installed')
    frequency, shape = own_mode(weightless)
    start = weightless.mesh.rest_positions + AMPLITUDE * shape
    times = np.linspace(0.0, 4.0 * np.pi / frequency, 80)[1:]
    frames = find_swing(find_simulator(name))(weightless, start, times)
    weights = weightless.vertex_masses[:, None] * shape
    moved = ((frames - weightless.mesh.rest_positions) * weights).sum(axis=(1, 2))
    own = AMPLITUDE * (weights * shape).sum()
    decay = 0.5 * weightless.stiffness_damping[0] * frequency**2
    rate = np.sqrt(frequency**2 - decay**2)
    wanted = np.exp(-decay * times) * (np.cos(rate * times) + decay / rate * np.sin(rate * times))
    # So much is gone after two swings that a wrong damping would show.
    assert np.exp(-decay * times[-1]) < 0.75
    assert np.abs(moved / own - wanted).max() < 0.03


def test_mujocos_step_is_short_beside_the_least_damped_region(body):
    factors = [group.stiffness_damping for group in material_groups(body)]
    assert time_step(material_groups(body)) == pytest.approx(0.2 * min(factors))
    still = material_groups(replace(body, damping=0.0 * body.damping))
    assert time_step(still) == 0.005
    hardly = replace(body, damping=1e-3 * body.damping)
    assert time_step(material_groups(hardly)) == 1e-4
