# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies, tables and air of the set `swings_two` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from support.blind_draws import STEPS
from support.blind_swings import (
    check_a_swing_keeps_its_energy,
    check_draws_by_its_energy,
    compliance,
    moves_by_size,
    soft_beam,
)

from benchmarks.blind.clamps import lining
from benchmarks.blind.creep import held_load
from benchmarks.blind.drag import AIR, make_cup
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import chain_lumps, lumps, positions_at
from benchmarks.blind.relaxation import GRADED, prony_pairs, root_pairs
from benchmarks.blind.rig_motion import acting, leaned
from benchmarks.blind.rotations import about, applied, rotation
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, settle, Specimen
from benchmarks.blind.swing import consistent_masses, with_lumps
from benchmarks.blind.swings_two_forms import SWINGS_TWO_FORMS
from benchmarks.blind.timing import draw_hold, draw_swing

FORMS = {form.key: form for form in SWINGS_TWO_FORMS}
CHAIN = Faults(chain_mass=2.0, chain_from=0.4, chain_side=-1.0)


@pytest.fixture(scope='module')
def setup() -> Setup:
    return soft_beam()


@pytest.fixture(scope='module')
def specimen(setup: Setup) -> Specimen:
    return make_specimen(setup, Faults(), refinement=0.5)


@pytest.fixture(scope='module')
def in_boot(setup: Setup) -> tuple[Faults, Specimen]:
    """Return a body in a boot, and what is wrong with that."""
    faults = Faults(clamp_form='boot', clamp_compliance=1.5)
    return faults, make_specimen(setup, faults, refinement=0.5)


@pytest.mark.parametrize('step', STEPS)
@pytest.mark.parametrize('mouth', [1.0, -1.0])
def test_a_cup_drags_by_what_it_takes_of_the_energy(
    specimen: Specimen, mouth: float, step: float
) -> None:
    """Its force is the slope of a potential of the speed: the cube, by the side that is ahead."""
    cup = make_cup(0.03, 0.8, mouth, specimen.areas, specimen.shares)
    random = np.random.default_rng(1)
    speeds = random.uniform(-1.0, 1.0, (len(specimen.shares), 3))
    move = random.standard_normal(speeds.shape)

    def potential(rates: np.ndarray) -> float:
        ahead = mouth * rates[:, 2]
        cubes = np.where(ahead > 0.0, ahead, -0.27 * np.cbrt(1.0 / 0.27) ** 2 * ahead) ** 3
        return float(cup.weights @ cubes) / 3.0

    slope = (potential(speeds + step * move) - potential(speeds - step * move)) / (2.0 * step)
    assert float((cup.forces(speeds) * move).sum()) == pytest.approx(slope, rel=1e-4)


def test_a_cup_is_held_back_by_its_mouth(specimen: Specimen) -> None:
    cup = make_cup(0.02, 0.8, -1.0, specimen.areas, specimen.shares)
    down, up = (
        cup.forces(np.tile([0.2, 0.5, speed], (len(specimen.shares), 1))) for speed in (-0.3, 0.3)
    )
    assert not down[:, :2].any()
    assert down[:, 2].sum() == pytest.approx(-0.5 * AIR * 0.02 * 0.3**2)
    # Hoerner: 1.42 with the mouth ahead, 0.38 with the round side ahead.
    np.testing.assert_allclose(up, -0.38 / 1.42 * down, rtol=0.01, atol=1e-12)
    felt = np.abs(down[:, 2])
    assert felt @ specimen.shares / felt.sum() == pytest.approx(0.8, abs=0.03)


def test_pairs_of_the_roots_law_are_that_law() -> None:
    times = np.geomspace(0.3, 40.0, 60)
    for time in (4.0, 8.0, 12.0):
        pairs = root_pairs(0.4, time)
        left = sum(share for share, _ in pairs)
        found = 1.0 - left + sum(share * np.exp(-times / tau) for share, tau in pairs)
        law = np.exp(-np.sqrt(times / time))
        # A part that relaxes within a tenth of a second is not seen.
        assert np.abs(found - found[0] - 0.4 * (law - law[0])).max() < 0.01
        assert left == pytest.approx(0.4, abs=0.04)


def test_a_light_load_creeps_as_the_compliance_of_its_law_says(specimen: Specimen) -> None:
    faults = Faults(creep_form='root', creep_share=0.4, creep_time=6.0)
    share = specimen.shares[specimen.body.cells] @ specimen.body.quadrature.values.T
    pairs, times = prony_pairs(faults, share), np.array([0.5, 2.5, 10.5])
    load = Load(specimen.body.masses[:, None] * np.array([0.0, 0.0, -0.01 * GRAVITY]))
    rest = specimen.mesh.nodes
    elastic = find_equilibrium(specimen.body, load, rest) - rest
    is_graded = faults.creep_form in GRADED
    held = held_load(specimen.body, load, rest, times, pairs, is_graded=is_graded)
    found = [float(((one - rest) * elastic).sum() / (elastic**2).sum()) for one in held]
    np.testing.assert_allclose(found, compliance(pairs, times), rtol=0.01)
    assert found[-1] > 1.25


def test_a_chain_lies_along_one_side_evenly(setup: Setup, specimen: Specimen) -> None:
    found, nodes = chain_lumps(specimen, setup, CHAIN), specimen.mesh.nodes
    assert found.sum() == pytest.approx(2e-3)
    assert (found >= 0.0).all()
    assert nodes[found > 0.0, 1] == pytest.approx(-0.5 * setup.shape.section[0])
    there = specimen.shares[found > 0.0]
    assert there.min() >= 0.4
    # As far as the nodes are apart, its middle is amid what it lies on.
    assert found @ specimen.shares / found.sum() == pytest.approx(0.7, abs=0.05)
    assert abs(float(found @ nodes[:, 2])) < 1e-9
    assert np.array_equal(lumps(specimen, setup, CHAIN), found)
    assert not chain_lumps(specimen, setup, Faults()).any()


@pytest.mark.parametrize('step', STEPS)
def test_a_chains_weight_is_the_slope_of_its_height(
    setup: Setup, specimen: Specimen, step: float
) -> None:
    """And its inertia that of its energy of motion: masses of single nodes have no others."""
    masses, nodes = chain_lumps(specimen, setup, CHAIN), specimen.mesh.nodes
    bare = consistent_masses(nodes, specimen.body, setup.density)
    laden = with_lumps(bare, specimen.body, masses)
    random = np.random.default_rng(3)
    speeds, move = random.standard_normal((2, *nodes.shape))

    def energy(rates: np.ndarray) -> float:
        local = rates[specimen.body.cells]
        return 0.5 * float(np.einsum('cai,cab,cbi', local, laden - bare, local))

    slope = (energy(speeds + step * move) - energy(speeds - step * move)) / (2.0 * step)
    assert slope == pytest.approx(float((masses[:, None] * speeds * move).sum()), rel=1e-4)
    down = np.array([0.1, 0.3, -GRAVITY])
    higher, lower = (-float(masses @ (nodes + way * step * move) @ down) for way in (1.0, -1.0))
    pushed = float((masses[:, None] * down * move).sum())
    assert (higher - lower) / (2.0 * step) == pytest.approx(-pushed, rel=1e-4)


def test_a_body_with_a_chain_twists_towards_it(setup: Setup, specimen: Specimen) -> None:
    down, rest = np.array([0.0, 0.0, -GRAVITY]), specimen.mesh.nodes
    masses = specimen.body.masses + chain_lumps(specimen, setup, CHAIN)
    bare, laden = (
        find_equilibrium(specimen.body, Load(each[:, None] * down), rest)
        for each in (specimen.body.masses, masses)
    )
    tip = specimen.shares > 0.99
    lower = (laden - bare)[tip, 2]
    side = rest[tip, 1] / (0.5 * setup.shape.section[0])
    assert lower.max() < -3e-4
    # The side of the chain sags more.
    assert lower[side < -0.9].mean() < lower[side > 0.9].mean() - 3e-5


@pytest.mark.parametrize('step', STEPS)
def test_a_boot_draws_by_its_energy(in_boot: tuple[Faults, Specimen], step: float) -> None:
    faults, specimen = in_boot
    law = lining(specimen, specimen.mesh.nodes, faults)
    moved = np.random.default_rng(1).uniform(-1e-3, 1e-3, specimen.mesh.nodes.shape)
    check_draws_by_its_energy(law, specimen.mesh.nodes + moved, step)


def test_a_rigid_body_turns_in_a_boot_by_its_compliance(
    in_boot: tuple[Faults, Specimen],
) -> None:
    """By the least energy under a moment, about y and about z, wherever it turns about."""
    faults, specimen = in_boot
    nodes = specimen.mesh.nodes
    law, moment, turns = lining(specimen, nodes, faults), 1e-3, []
    for axis in np.eye(3)[1:]:

        def energy(angle: float, axis: np.ndarray = axis) -> float:
            turned = applied(about(rotation(angle * axis), specimen.center, np.zeros(3)), nodes)
            return law(turned).energy - moment * angle

        turns.append(minimize_scalar(energy, bounds=(-0.02, 0.02), method='bounded').x)
    assert np.mean(turns) == pytest.approx(1e-3 * faults.clamp_compliance, rel=0.02)
    # It is as soft all along.
    pushed = law(nodes + np.array([0.0, 0.0, 1e-3])).gradient
    held = specimen.mesh.held[specimen.areas[specimen.mesh.held] > 0.0]
    by_area = pushed[held, 2] / specimen.areas[held]
    np.testing.assert_allclose(by_area, by_area[0])
    assert not np.delete(pushed, held, axis=0).any()


def test_a_swing_in_a_boot_keeps_its_energy(
    setup: Setup, in_boot: tuple[Faults, Specimen]
) -> None:
    """All forces of a motion at once: what springs have is not there else."""
    faults, specimen = in_boot
    check_a_swing_keeps_its_energy(specimen, setup, faults)


def test_a_body_in_a_boot_lies_on_its_ledge_and_rests_as_at_last(
    setup: Setup, in_boot: tuple[Faults, Specimen]
) -> None:
    faults, specimen = in_boot
    view = setup.observations[0]
    timing = draw_swing(np.random.default_rng(2))
    (lying,) = positions_at(specimen, setup, view, faults, timing, [-0.1])
    end = specimen.shares > 0.999
    np.testing.assert_allclose(lying[end], specimen.mesh.nodes[end], atol=1e-12)
    clamp = specimen.mesh.held
    assert 1e-6 < np.abs((lying - specimen.mesh.nodes)[clamp]).max() < 1e-3
    # Without the ledge it sags by more than in a stiff clamp.
    stiff = make_specimen(setup, Faults(), refinement=0.5)
    gone = settle(specimen, setup, view, faults) - settle(stiff, setup, view, Faults())
    assert np.linalg.norm(gone[end].mean(axis=0)) > 2e-3


def test_a_table_on_air_sways_as_a_sine(setup: Setup) -> None:
    faults = Faults(tilt_form='swaying', gravity_tilt=(12.0, -5.0), tilt_rate=1.3, tilt_phase=0.4)
    down = np.array([0.0, -GRAVITY, 0.0])
    times = np.linspace(-0.2, 0.6, 33)
    found = np.array([leaned(faults, time) + down for time in times])
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), GRAVITY)
    angles = np.arctan2(-found[:, 2], -found[:, 1])
    whole = np.rad2deg(np.arccos(found @ down / GRAVITY**2))
    expected = 13.0 * np.sin(2.0 * np.pi * 1.3 * times + 0.4)
    np.testing.assert_allclose(whole, np.abs(expected), atol=1e-5)
    # About x, what is below goes to the back, and to the other side half a period on.
    np.testing.assert_allclose(np.sign(angles), np.sign(expected))
    assert (angles > 0.0).any()
    assert (angles < 0.0).any()


@pytest.mark.parametrize('step', STEPS)
def test_a_swaying_tables_pull_is_the_slope_of_a_height(
    setup: Setup, specimen: Specimen, step: float
) -> None:
    """Of nodes above a level that leans the other way."""
    faults = Faults(tilt_form='swaying', gravity_tilt=(9.0, 4.0), tilt_rate=1.2, tilt_phase=0.5)
    view, masses = setup.observations[0], specimen.body.masses
    changing = acting(view, faults, masses, 0.0 * masses)
    assert changing is not None
    time, nodes = 0.11, specimen.mesh.nodes
    share = np.sin(2.0 * np.pi * 1.2 * time + 0.5)
    up = rotation(share * np.deg2rad([9.0, 0.0, 4.0])) @ np.array([0.0, 1.0, 0.0])
    move = np.random.default_rng(4).standard_normal(nodes.shape)

    def energy(places: np.ndarray) -> float:
        room = applied(view.world_from_object, places)
        return GRAVITY * float(masses @ (room @ up - room[:, 1]))

    slope = (energy(nodes + step * move) - energy(nodes - step * move)) / (2.0 * step)
    assert float((changing(time) * move).sum()) == pytest.approx(-slope, rel=1e-4)


def test_a_body_on_a_swaying_table_is_let_go_as_it_lies(setup: Setup, specimen: Specimen) -> None:
    view, timing = setup.observations[0], draw_swing(np.random.default_rng(2))
    faults = Faults(tilt_form='swaying', gravity_tilt=(15.0, 0.0), tilt_rate=1.2, tilt_phase=1.5)
    (lying,), (other,) = (
        positions_at(specimen, setup, view, each, timing, [-0.1]) for each in (faults, Faults())
    )
    turned = view.world_from_object[:3, :3].T @ np.array([0.0, 0.0, -1.0])
    aside = (lying - other) @ turned
    assert 1e-6 < aside.max() < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize('key', [key for key in FORMS if not key.startswith(('time', 'depth'))])
def test_sizes_are_seen_and_the_large_one_is_about_twice_the_medium_one(key: str) -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    timing = (draw_hold if key.startswith('creep') else draw_swing)(np.random.default_rng(2))
    moves = moves_by_size(drawn, FORMS[key].effect, replace(timing, frame_count=15))
    assert 1.0 < moves[0] < 7.0
    assert 1.5 < moves[1] / moves[0] < 3.2
