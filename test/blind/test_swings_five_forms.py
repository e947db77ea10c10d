# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Brackets, packs, air and rubber of the set `swings_five` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from support.blind_draws import STEPS
from support.blind_swings import check_a_swing_keeps_its_energy, moves_by_size, soft_beam

from benchmarks.blind.bracket import bracket, turned
from benchmarks.blind.breeze import breeze_push, make_breeze
from benchmarks.blind.clamps import lining
from benchmarks.blind.drag import AIR, make_drag, make_felts, make_fur
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import lumps, positions_at
from benchmarks.blind.frothing import froth_share
from benchmarks.blind.moduli import log_modulus
from benchmarks.blind.oiling import depth_below
from benchmarks.blind.relaxation import prony_pairs
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.swing import consistent_masses, Forces, swing
from benchmarks.blind.swings_five_forms import SWINGS_FIVE_FORMS
from benchmarks.blind.swings_five_outside import SWINGS_FIVE_OUTSIDE
from benchmarks.blind.timing import draw_hold, draw_swing

BENT = Faults(clamp_form='bracket', clamp_compliance=1.5, bracket_drop=15.0)
BREEZE = Faults(tilt_form='breeze', gravity_tilt=(12.0, -3.0), breeze_speed=4.0)


@pytest.fixture(scope='module')
def setup() -> Setup:
    return soft_beam()


@pytest.fixture(scope='module')
def specimen(setup: Setup) -> Specimen:
    return make_specimen(setup, Faults(), refinement=0.5)


@pytest.fixture(scope='module')
def on_bracket(setup: Setup) -> Specimen:
    return make_specimen(setup, BENT, refinement=0.5)


@pytest.mark.parametrize('step', STEPS)
def test_a_bracket_draws_by_its_energy_and_gives_way_as_it_says(step: float) -> None:
    random = np.random.default_rng(1)
    places, move = random.standard_normal((2, 6, 3))
    law = bracket(places, random.uniform(1.0, 9.0, 6), np.array([0.1, 0.0, -0.4]), 0.03)
    there = places + 0.2 * random.standard_normal(places.shape)
    here, one, other = (law(there + way * step * move) for way in (0.0, 1.0, -1.0))
    slope = float((here.gradient * move).sum())
    assert (one.energy - other.energy) / (2.0 * step) == pytest.approx(slope, rel=1e-4)
    assert here.shared is not None
    change = np.einsum('nij,nj->ni', here.diagonal, move)
    change -= here.shared * float((here.shared * move).sum())
    found = (one.gradient - other.gradient) / (2.0 * step)
    assert np.abs(found - change).max() < 1e-4 * np.abs(change).max()


def test_a_brackets_energy_is_the_least_over_its_turns() -> None:
    random = np.random.default_rng(4)
    places, stiff, foot = random.standard_normal((5, 3)), random.uniform(1.0, 9.0, 5), np.ones(3)
    there = places + 0.3 * random.standard_normal(places.shape)

    def whole(turn: float) -> float:
        off = there - foot - turned(places - foot, turn)
        return float(0.5 * stiff @ (off**2).sum(axis=1) + 0.5 * turn**2 / 0.2)

    least = minimize_scalar(whole, bounds=(-1.5, 1.5), method='bounded', options={'xatol': 1e-9})
    assert bracket(places, stiff, foot, 0.2)(there).energy == pytest.approx(least.fun, rel=1e-9)


def test_a_bracket_turns_what_it_holds_by_the_moment_about_its_bend(
    on_bracket: Specimen,
) -> None:
    load = on_bracket.body.masses[:, None] * np.array([0.0, 0.0, -GRAVITY])
    nodes, foot = on_bracket.mesh.nodes, np.array([0.0, 0.0, -0.015])
    rest = find_equilibrium(on_bracket.body, Load(load, (lining(on_bracket, nodes, BENT),)), nodes)
    moment = float(np.cross(rest - foot, load).sum(axis=0)[1])
    held = on_bracket.mesh.held
    as_it_says = foot + turned(nodes[held] - foot, 1.5 * moment)
    assert np.abs(nodes[held] - as_it_says).max() > 5e-4
    np.testing.assert_allclose(rest[held], as_it_says, atol=3e-5)


def test_a_swing_on_a_bracket_keeps_its_energy(setup: Setup, on_bracket: Specimen) -> None:
    check_a_swing_keeps_its_energy(on_bracket, setup, BENT)


@pytest.mark.parametrize('step', [1e-3, 1e-4, 1e-5])
@pytest.mark.parametrize('is_fur', [True, False])
def test_fur_and_felts_hold_back_by_the_slope_of_their_potentials(
    specimen: Specimen, is_fur: bool, step: float
) -> None:
    areas, shares = specimen.areas, specimen.shares
    drag = make_fur(0.02, 0.6, areas, shares) if is_fur else make_felts(0.03, 0.8, areas, shares)
    random = np.random.default_rng(1)
    speeds = random.uniform(-0.7, 0.7, (len(shares), 3))
    move = random.standard_normal(speeds.shape)

    def potential(velocities: np.ndarray) -> np.ndarray:
        size = np.linalg.norm(velocities, axis=1)
        fur = 0.5 ** (2.0 / 3.0) * 3.0 / 7.0 * size ** (7.0 / 3.0)
        felt = 0.25 * (size - 0.02 * np.log1p(size / 0.02))
        return drag.weights * (fur if is_fur else felt)

    change = potential(speeds + step * move) - potential(speeds - step * move)
    slopes = (drag.forces(speeds) * move).sum(axis=1)
    assert np.abs(change / (2.0 * step) - slopes).max() < 1e-3 * np.abs(slopes).max()
    assert np.abs(slopes).max() > 0.0
    assert (drag.forces(speeds) * speeds).sum(axis=1).min() >= 0.0


def test_fur_and_felts_are_as_large_as_they_say_and_where(specimen: Specimen) -> None:
    areas, shares = specimen.areas, specimen.shares
    way = np.tile([0.3, 0.0, -0.4], (len(shares), 1))
    fur = make_fur(0.02, 0.6, areas, shares).forces(way)
    np.testing.assert_allclose(fur.sum(axis=0), 0.5 * AIR * 0.02 * 0.5 * way[0])
    assert not fur[shares < 0.6].any()
    felts = make_felts(0.03, 0.8, areas, shares).forces(100.0 * way)
    np.testing.assert_allclose(felts.sum(axis=0), 0.03 * way[0] / 0.5, rtol=1e-3)
    size = np.linalg.norm(felts, axis=1)
    assert size @ shares / size.sum() == pytest.approx(0.8, abs=0.03)


def test_a_breeze_pushes_as_its_tilt_says_and_drags_what_moves_in_it(
    setup: Setup, specimen: Specimen
) -> None:
    view = setup.observations[0]
    turn, push = view.world_from_object[:3, :3], breeze_push(specimen, view, BREEZE)
    mass = specimen.body.masses[specimen.shares > 0.0].sum()
    x, z = np.deg2rad(BREEZE.gravity_tilt)
    angle = np.hypot(x, z)
    # Gravity that turns about a level axis comes to have its sine across that.
    across = np.sin(angle) / angle * GRAVITY * mass * np.array([z, 0.0, -x])
    np.testing.assert_allclose(turn @ push.sum(axis=0), across, rtol=1e-9, atol=1e-12)
    breeze = make_breeze(specimen, view, BREEZE)
    assert breeze.wind is not None
    assert np.linalg.norm(breeze.wind) == pytest.approx(4.0)
    # What goes with it feels nothing, what goes as fast against it feels four times as much.
    along = np.tile(breeze.wind, (len(push), 1))
    np.testing.assert_allclose(breeze.forces(along), 0.0, atol=1e-12)
    np.testing.assert_allclose(-breeze.forces(-along), 4.0 * push, atol=1e-12)
    assert not breeze_push(specimen, view, replace(BREEZE, tilt_form='tilt')).any()


def test_a_body_swings_aside_in_a_breeze_as_in_its_push_the_less_the_slower_that_is(
    setup: Setup, specimen: Specimen
) -> None:
    """Past a stream that is fast by far a body's own speed is nothing: a dead push is left."""
    timing, view = draw_swing(np.random.default_rng(2)), setup.observations[0]
    fast, slow, still = (
        positions_at(specimen, setup, view, each, timing, [-0.1, 0.04])
        for each in (
            replace(BREEZE, breeze_speed=1e4),
            replace(BREEZE, breeze_speed=1.0),
            Faults(),
        )
    )
    down = -GRAVITY * view.world_from_object[1, :3]
    load = specimen.body.masses[:, None] * down + breeze_push(specimen, view, BREEZE)
    masses = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    air = make_drag(specimen.mesh, 0.0)
    forces = Forces(load, timing.damping, air, setup.youngs_modulus)
    [expected] = swing(specimen.body, masses, forces, fast[0], [0.04], 1.0 / 600.0)
    assert np.abs(fast[1] - expected).max() < 0.01 * np.abs(expected - still[1]).max()
    aside = [np.abs(each[1] - still[1]).max() for each in (fast, slow)]
    assert 1e-3 < aside[1] < 0.97 * aside[0]


def test_a_pack_lies_below_and_weighs_what_it_says(setup: Setup, specimen: Specimen) -> None:
    found = lumps(specimen, setup, Faults(pack_mass=3.0, pack_from=0.5, pack_until=0.8))
    assert found.sum() == pytest.approx(3e-3)
    there = found > 0.0
    assert 0.5 <= specimen.shares[there].min() < specimen.shares[there].max() <= 0.8
    assert np.ptp(specimen.mesh.lattice[there, 2]) == pytest.approx(0.0, abs=1e-12)
    assert specimen.mesh.lattice[there, 2].max() < -0.49 * setup.shape.section[1]
    assert found @ specimen.shares / found.sum() == pytest.approx(0.65, abs=0.03)


def test_oil_makes_creep_what_lies_near_the_surface(setup: Setup, specimen: Specimen) -> None:
    below = depth_below(specimen, setup)
    faults = Faults(creep_form='oiled', creep_share=0.6, creep_time=5.0, creep_depth=2.0)
    [(share, time)] = prony_pairs(faults, 0.0 * below, below)
    assert time == 5.0
    np.testing.assert_allclose(share[..., 0, 0], 0.6 * np.exp(-0.5 * below))
    # The mean of the way to the nearest side, over a section as it is cut into cells.
    width, height = 1e3 * np.array(setup.shape.section)
    least, other = min(width, height), max(width, height)
    exact = 0.25 * least - least**2 / (12.0 * other)
    volumes = specimen.body.quadrature.volumes
    assert (below * volumes).sum() / volumes.sum() == pytest.approx(exact, rel=0.06)


def test_bubbles_are_at_the_upper_edge_by_the_clamp(setup: Setup) -> None:
    share, height = np.array([[0.0, 0.0, 1.0, 0.5]]), np.array([[1.0, -1.0, 1.0, 0.0]])
    np.testing.assert_allclose(froth_share(share, height), [[1.0, 0.0, 0.0, 0.25]])
    points = np.zeros((1, 3, 4))
    points[0, 2] = 0.5 * setup.shape.section[1] * height[0]
    faults = Faults(contrast_mode='frothed', contrast=-0.8)
    found = log_modulus(setup, faults, share, points)
    np.testing.assert_allclose(found, [[-0.8, 0.0, 0.0, -0.2]], atol=1e-12)


_MOVING = {
    **{form.key: form.effect for form in SWINGS_FIVE_FORMS if form.truth != 'time_offset'},
    **SWINGS_FIVE_OUTSIDE,
}
_MOVING.pop('depth_affine/dented window')


@pytest.mark.slow
@pytest.mark.parametrize('key', _MOVING)
def test_sizes_are_seen_and_the_large_one_is_about_twice_the_medium_one(key: str) -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    is_slow = key.startswith('creep')
    timing = (draw_hold if is_slow else draw_swing)(np.random.default_rng(2))
    moves = moves_by_size(drawn, _MOVING[key], replace(timing, frame_count=15 + 7 * is_slow), 0.6)
    assert 2.0 < moves[0] < 7.0
    assert 1.4 < moves[1] / moves[0] < 3.2
