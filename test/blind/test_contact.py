# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What bodies lie on and are pulled by: energies, their slopes, and what comes of them."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.blind.contact import (
    BAR,
    contact_laws,
    FRICTION,
    friction,
    half_space,
    highest_tops,
)
from benchmarks.blind.equilibrium import PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.heights import by_height
from benchmarks.blind.pulls import magnet, tether
from benchmarks.blind.rotations import applied, rigid, rotation
from benchmarks.blind.setups import draw_setup, Observation, Setup
from benchmarks.blind.simulation import make_specimen, settle

COARSE = 0.5
COUNT = 12


def _view() -> Observation:
    turn = rotation(np.array([0.4, -0.7, 0.2]))
    return Observation('level', rigid(turn, np.array([0.01, -0.02, 0.03])))


def _round(form: str, places: np.ndarray) -> PotentialLaw:
    """Return what is round with its top some millimetres above the middle of places."""
    middle = applied(_view().world_from_object, places).mean(axis=0)
    faults = Faults(
        contact_form=form, contact_at=float(middle[0]), contact_height=float(middle[1]) + BAR
    )
    (law,) = contact_laws(np.full(COUNT, 1e-6), np.ones(COUNT), _view(), faults)
    return law


def _by_height(places: np.ndarray, **changes: Any) -> PotentialLaw:
    """Return what depends on the heights of nodes, the middle one of which is at 0."""
    middle = applied(_view().world_from_object, places)[:, 1].mean()
    faults = replace(Faults(bath_level=middle, mass_table=middle - 0.02), **changes)
    masses, shares = np.linspace(0.001, 0.002, COUNT), np.linspace(0.1, 1.0, COUNT)
    (law,) = by_height(places + 0.01, masses, shares, _view(), faults)
    return law


LAWS: dict[str, Callable[[np.ndarray], PotentialLaw]] = {
    'edge': lambda places: _round('edge', places),
    'roll': lambda places: _round('roll', places),
    'bath': lambda places: _by_height(places, bath=0.7),
    'trailing': lambda places: _by_height(
        places, mass_form='trailing', added_mass=3.0, added_mass_at=0.6, mass_drop=0.08
    ),
    'friction': lambda places: friction(
        np.array([0.0, 0.6, 0.8]), np.linspace(0.1, 0.4, COUNT), places + 2e-4
    ),
    'magnet': lambda places: magnet(np.array([0.1, 0.05, -0.03]), np.linspace(1e-5, 1e-3, COUNT)),
    'tether': lambda places: tether(
        np.array([0.05, 0.02, -0.03]), np.linspace(1.0, 9.0, COUNT), 0.03
    ),
}


@pytest.mark.parametrize('name', sorted(LAWS))
@pytest.mark.parametrize('step', [4e-6, 2e-6, 1e-6])
def test_forces_and_stiffness_are_slopes(name: str, step: float) -> None:
    random = np.random.default_rng(1)
    places = random.uniform(-0.003, 0.003, size=(COUNT, 3))
    law = LAWS[name](places)
    move = random.standard_normal((COUNT, 3))
    high, low = (law(places + sign * step * move) for sign in (1.0, -1.0))
    here = law(places)
    slope = (high.energy - low.energy) / (2.0 * step)
    assert slope == pytest.approx(float((here.gradient * move).sum()), rel=1e-3)
    change = (high.gradient - low.gradient) / (2.0 * step)
    found = np.einsum('nij,nj->ni', here.diagonal, move)
    assert np.abs(change).max() > 0.0
    assert np.allclose(found, change, rtol=0.0, atol=2e-3 * np.abs(change).max())


@pytest.fixture(scope='module')
def setup() -> Setup:
    return draw_setup('beam', is_sealed=False, poses=4, random=np.random.default_rng(4))


def _lying(setup: Setup, form: str, lift: float) -> tuple[Faults, np.ndarray, np.ndarray]:
    """Return faults, where the body hangs without, and where it lies, in the first pose."""
    free = Faults()
    view = setup.observations[0]
    specimen = make_specimen(setup, free, COARSE)
    hanging = settle(specimen, setup, view, free)
    world = applied(view.world_from_object, hanging)
    over = np.abs(specimen.shares - 0.7).argmin()
    faults = Faults(contact_form=form, contact_at=float(world[over, 0]))
    top = float(highest_tops(world, faults).min()) + lift
    faults = Faults(contact_form=form, contact_at=faults.contact_at, contact_height=top)
    return faults, hanging, settle(specimen, setup, view, faults)


def test_a_bar_lifts_what_lies_over_it_and_lets_the_tip_hang_beyond(setup: Setup) -> None:
    faults, hanging, lying = _lying(setup, 'edge', 0.004)
    world = [applied(setup.observations[0].world_from_object, each) for each in (hanging, lying)]
    tops = highest_tops(world[1], faults)
    assert faults.contact_height is not None
    # It rests on the bar, within the microns that it sinks in.
    assert tops.min() == pytest.approx(faults.contact_height, abs=2e-4)
    assert (world[1] - world[0])[:, 1].max() > 0.003
    assert world[1][:, 1].min() < faults.contact_height - 0.001


def test_friction_bears_half_of_what_presses_and_holds_the_body_back(setup: Setup) -> None:
    specimen, view = make_specimen(setup, Faults(), COARSE), setup.observations[0]
    faults, hanging, rubbed = _lying(setup, 'friction', 0.006)
    smooth = _lying(setup, 'hard', 0.006)[2]
    normal, _ = half_space(view, faults)
    (plane,) = contact_laws(specimen.areas, specimen.shares, view, faults)
    pushes = np.linalg.norm(plane(rubbed).gradient, axis=1)
    touches = pushes > 0.05 * pushes.max()
    ways = []
    for rest in (smooth, rubbed):
        way = rest - hanging
        ways.append(np.linalg.norm(way - np.outer(way @ normal, normal), axis=1)[touches].max())
    assert ways[1] < 0.95 * ways[0]
    # Equilibrium by another route: what the body itself asks of the nodes that touch.
    asked = specimen.body.evaluate(rubbed, with_stiffness=False).gradient
    weight = specimen.body.masses[:, None] * (view.world_from_object[1, :3] * -9.81)
    force = (asked - weight)[touches]
    pressing = force @ normal
    across = np.linalg.norm(force - np.outer(pressing, normal), axis=1)
    assert (across <= FRICTION * pressing * 1.001).all()
    assert across.max() > 0.8 * FRICTION * pressing[across.argmax()]


def test_friction_leaves_a_body_alone_that_does_not_touch(setup: Setup) -> None:
    _, hanging, lying = _lying(setup, 'friction', -0.002)
    assert np.array_equal(hanging, lying)


@pytest.mark.parametrize('name', ['magnet', 'tether'])
def test_a_pull_goes_to_its_point_and_is_as_strong_as_stated(setup: Setup, name: str) -> None:
    view = setup.observations[0]
    specimen = make_specimen(setup, Faults(), COARSE)
    hanging = settle(specimen, setup, view, Faults())
    tip = specimen.shares > 0.99
    world = applied(view.world_from_object, hanging)[tip].mean(axis=0)
    point = world + np.array([0.0, 0.12, 0.05])
    faults = Faults(
        **{name: 0.02},
        tether_slack=0.5,
        pull_point=tuple(point),
        pull_distance=0.13,
    )
    moved = applied(view.world_from_object, settle(specimen, setup, view, faults))[tip]
    way = moved.mean(axis=0) - world
    across = view.world_from_object[:3, :3].T @ way
    wanted = view.world_from_object[:3, :3].T @ (point - world)
    # Along its length a body hardly gives way.
    assert across[1:] @ wanted[1:] > 0.8 * np.linalg.norm(across[1:]) * np.linalg.norm(wanted[1:])
    assert np.linalg.norm(way) > 2e-4
