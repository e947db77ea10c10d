# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies, jaws and air of the set `swings_three` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from support.blind_draws import STEPS
from support.blind_swings import (
    check_a_swing_keeps_its_energy,
    check_draws_by_its_energy,
    energies_of_a_swing,
    moves_by_size,
    soft_beam,
)

from benchmarks.blind.clamps import lining
from benchmarks.blind.creep import held_load
from benchmarks.blind.drag import AIR, make_vane
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import drawing, leak_lumps, lumps, positions_at
from benchmarks.blind.relaxation import material_times, prony_pairs
from benchmarks.blind.rotations import about, applied, rotation
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, settle, Specimen
from benchmarks.blind.springs import putty, springs
from benchmarks.blind.swings_three_forms import SWINGS_THREE_FORMS
from benchmarks.blind.timing import draw_hold, draw_swing
from benchmarks.blind.wadding import wadding, wadding_under

FORMS = {form.key: form for form in SWINGS_THREE_FORMS}
LAMP = Faults(
    creep_form='warmed', creep_share=0.3, creep_time=70.0, creep_haste=11.0, creep_warmth=9.0
)
LEAK = Faults(leak_mass=3.0, leak_at=0.8, leak_time=24.0)
WOOL = Faults(wool=30.0, wool_from=0.7, wool_top=0.7, wool_floor=2.3)


@pytest.fixture(scope='module')
def setup() -> Setup:
    return soft_beam()


@pytest.fixture(scope='module')
def specimen(setup: Setup) -> Specimen:
    return make_specimen(setup, Faults(), refinement=0.5)


@pytest.fixture(scope='module')
def weight(setup: Setup, specimen: Specimen) -> np.ndarray:
    down = -GRAVITY * setup.observations[0].world_from_object[1, :3]
    return specimen.body.masses[:, None] * down


@pytest.fixture(scope='module')
def rest(specimen: Specimen, weight: np.ndarray) -> np.ndarray:
    return find_equilibrium(specimen.body, Load(weight), specimen.mesh.nodes)


@pytest.fixture(scope='module')
def in_putty(setup: Setup) -> tuple[Faults, Specimen]:
    """Return a body in putty, and what is wrong with that."""
    faults = Faults(clamp_form='putty', clamp_compliance=1.5, putty_give=0.6)
    return faults, make_specimen(setup, faults, refinement=0.5)


@pytest.mark.parametrize('degrees', [0.0, 25.0, 70.0, 130.0, -60.0])
def test_a_vane_feels_a_stream_across_its_face(specimen: Specimen, degrees: float) -> None:
    """By the cosine of the angle to its normal, and along that wherever the stream comes from."""
    vane = make_vane(0.02, 0.8, 35.0, specimen.areas, specimen.shares)
    normal = np.array([0.0, np.sin(np.deg2rad(35.0)), np.cos(np.deg2rad(35.0))])
    aside = np.array([0.6, 0.8 * normal[2], -0.8 * normal[1]])
    angle = np.deg2rad(degrees)
    speed = 0.4 * (np.cos(angle) * normal + np.sin(angle) * aside)
    found = vane.forces(np.tile(speed, (len(specimen.shares), 1)))
    whole = 0.5 * AIR * 0.02 * 0.4**2 * np.cos(angle) * normal
    np.testing.assert_allclose(found.sum(axis=0), whole, atol=1e-12)
    felt = np.abs(found @ normal)
    assert felt @ specimen.shares / felt.sum() == pytest.approx(0.8, abs=0.03)


@pytest.mark.parametrize('step', STEPS)
def test_a_vane_takes_the_power_that_goes_with_the_cube(specimen: Specimen, step: float) -> None:
    """Three times a third of that is its slope as all goes faster: none is ever given back."""
    vane = make_vane(0.03, 0.75, -40.0, specimen.areas, specimen.shares)
    speeds = np.random.default_rng(1).uniform(-1.0, 1.0, (len(specimen.shares), 3))
    across = speeds @ np.array([0.0, -np.sin(np.deg2rad(40.0)), np.cos(np.deg2rad(40.0))])

    def potential(factor: float) -> float:
        squares = np.linalg.norm(factor * speeds, axis=1) * (factor * across) ** 2
        return float(vane.weights @ squares) / 3.0

    slope = (potential(1.0 + step) - potential(1.0 - step)) / (2.0 * step)
    powers = (vane.forces(speeds) * speeds).sum(axis=1)
    assert powers.min() >= 0.0
    assert powers.sum() == pytest.approx(slope, rel=1e-4)
    assert vane.weights.sum() == pytest.approx(0.5 * AIR * 0.03)


def test_a_body_with_a_vane_swings_to_one_side(setup: Setup, specimen: Specimen) -> None:
    timing, view = draw_swing(np.random.default_rng(2)), setup.observations[0]
    vane = Faults(drag_form='vane', drag_area=4000.0, drag_at=0.9)
    end = specimen.shares > 0.99
    without, one, other = (
        positions_at(specimen, setup, view, each, timing, [0.04])[0][end].mean(axis=0)
        for each in (
            Faults(),
            replace(vane, drag_slant=40.0),
            replace(vane, drag_slant=-40.0),
        )
    )
    # It goes down less far, and to where the plate leans as it does.
    assert min(one[2], other[2]) > without[2] + 1e-4
    assert one[1] > without[1] + 5e-5
    assert other[1] < without[1] - 5e-5


@pytest.mark.parametrize('step', [1e-2, 1e-3, 1e-4])
def test_a_lamp_makes_a_body_relax_faster_and_faster(step: float) -> None:
    for time in (0.5, 6.0, 30.0):
        one, other = material_times(LAMP, [time + step, time - step])
        rate = 1.0 + 10.0 * (1.0 - np.exp(-time / 9.0))
        assert (one - other) / (2.0 * step) == pytest.approx(rate, rel=1e-4)
    whole, _ = quad(lambda t: 11.0 - 10.0 * np.exp(-t / 9.0), 0.0, 20.0)
    assert material_times(LAMP, [0.0, 20.0]) == pytest.approx([0.0, whole])
    assert material_times(replace(LAMP, creep_form='one'), [3.0, 20.0]) == [3.0, 20.0]


def test_a_warmed_body_creeps_as_the_compliance_of_its_own_time_says(specimen: Specimen) -> None:
    """Of one pair that is known in full: a standard solid."""
    share = specimen.shares[specimen.body.cells] @ specimen.body.quadrature.values.T
    when = np.array([1.0, 5.0, 12.0, 34.0])
    load = Load(specimen.body.masses[:, None] * np.array([0.0, 0.0, -0.01 * GRAVITY]))
    nodes = specimen.mesh.nodes
    elastic = find_equilibrium(specimen.body, load, nodes) - nodes
    own = material_times(LAMP, when)
    held = held_load(specimen.body, load, nodes, own, prony_pairs(LAMP, share))
    found = [float(((one - nodes) * elastic).sum() / (elastic**2).sum()) for one in held]
    softer = 1.0 / 0.7 - 0.3 / 0.7 * np.exp(-0.7 * np.array(own) / 70.0)
    np.testing.assert_allclose(found, softer, rtol=1e-3)
    # It hardly goes at first, and has a turning point.
    rises = np.diff([1.0, *found]) / np.diff([0.0, *when])
    assert rises[0] < 0.7 * rises[1]
    assert rises[1] > rises[3]


def test_a_warmed_body_is_where_a_cool_one_comes_later(setup: Setup, specimen: Specimen) -> None:
    timing, view = draw_hold(np.random.default_rng(2)), setup.observations[0]
    times = [2.0, 9.0]
    warm = positions_at(specimen, setup, view, LAMP, timing, times)
    cool = replace(LAMP, creep_form='one')
    later = positions_at(specimen, setup, view, cool, timing, material_times(LAMP, times))
    np.testing.assert_allclose(warm, later, atol=1e-12)
    as_late = positions_at(specimen, setup, view, cool, timing, times)
    assert np.abs(warm[1] - as_late[1]).max() > 3e-4


def test_water_runs_out_the_slower_the_lower_it_stands(specimen: Specimen) -> None:
    """By the root of its height, as Torricelli's law has it."""
    for time in (0.0, 5.0, 14.0, 22.0):
        grams = 1e3 * leak_lumps(specimen, LEAK, time).sum()
        rate = 1e3 * (
            leak_lumps(specimen, LEAK, time + 1e-4).sum()
            - leak_lumps(specimen, LEAK, time - 1e-4).sum()
        )
        assert rate / 2e-4 == pytest.approx(-2.0 * np.sqrt(3.0 * grams) / 24.0, rel=1e-3)
    found = leak_lumps(specimen, LEAK, 0.0)
    assert found.sum() == pytest.approx(3e-3)
    assert found @ specimen.shares / found.sum() == pytest.approx(0.8, abs=0.02)
    assert not leak_lumps(specimen, LEAK, 24.1).any()
    assert not leak_lumps(specimen, Faults(), 0.0).any()


def test_a_body_rises_as_its_load_runs_out(
    setup: Setup, specimen: Specimen, weight: np.ndarray, rest: np.ndarray
) -> None:
    timing, view = draw_hold(np.random.default_rng(2)), setup.observations[0]
    times = [-1.0, 0.01, 6.0, 15.0, 40.0]
    lying, *found = positions_at(specimen, setup, view, LEAK, timing, times)
    end = specimen.shares > 0.999
    np.testing.assert_allclose(lying[end], specimen.mesh.nodes[end], atol=1e-12)
    up = view.world_from_object[1, :3]
    rises = np.diff([float((place[end] @ up).mean()) for place in found])
    assert rises.min() > 5e-5
    np.testing.assert_allclose(found[-1], rest, atol=1e-6)
    # At each time the energy is least, of what is left.
    left = leak_lumps(specimen, LEAK, 6.0)
    pull = weight + left[:, None] * weight / specimen.body.masses[:, None]
    move = found[1] - specimen.mesh.nodes

    def energy(places: np.ndarray, loads: np.ndarray) -> float:
        stored = specimen.body.evaluate(places, with_stiffness=False).energy
        return stored - float((loads * places).sum())

    slopes = [
        energy(found[1] + 1e-3 * move, loads) - energy(found[1] - 1e-3 * move, loads)
        for loads in (pull, weight)
    ]
    assert abs(slopes[0]) < 0.01 * abs(slopes[1])
    assert np.array_equal(lumps(specimen, setup, LEAK), leak_lumps(specimen, LEAK, 0.0))


@pytest.mark.parametrize('step', STEPS)
def test_putty_draws_by_its_energy(in_putty: tuple[Faults, Specimen], step: float) -> None:
    faults, specimen = in_putty
    law = lining(specimen, specimen.mesh.nodes, replace(faults, putty_give=10.0))
    moved = np.random.default_rng(1).uniform(-4e-3, 5e-3, specimen.mesh.nodes.shape)
    check_draws_by_its_energy(law, specimen.mesh.nodes + moved, step)


def test_putty_holds_as_springs_do_at_first_and_by_no_more_than_it_can() -> None:
    places, stiffness = np.zeros((4, 3)), np.array([100.0, 250.0, 0.0, 40.0])
    law, linear = putty(places, stiffness, 2e-4), springs(places, stiffness)
    way = np.array([[0.6, 0.0, -0.8], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-0.36, 0.48, 0.8]])
    near, far = 1e-7 * way, 5e-2 * way
    np.testing.assert_allclose(law(near).gradient, linear(near).gradient, rtol=1e-5)
    np.testing.assert_allclose(law(far).gradient, 2e-4 * stiffness[:, None] * way, rtol=1e-4)
    # As far as it would give at most, by the root of a half.
    half = np.sqrt(0.5) * linear(2e-4 * way).gradient
    np.testing.assert_allclose(law(2e-4 * way).gradient, half)


def test_a_rigid_body_turns_in_putty_by_more_than_its_compliance_the_harder_it_is_loaded(
    in_putty: tuple[Faults, Specimen],
) -> None:
    faults, specimen = in_putty
    nodes = specimen.mesh.nodes
    law, found = lining(specimen, nodes, faults), []
    for moment in (1e-4, 0.05):
        turns = []
        for axis in np.eye(3)[1:]:

            def energy(angle: float, axis: np.ndarray = axis, moment: float = moment) -> float:
                turned = about(rotation(angle * axis), specimen.center, np.zeros(3))
                return (law(applied(turned, nodes)).energy - moment * angle) / moment

            bounds = (-5.0 * moment, 5.0 * moment)
            options = {'xatol': 1e-4 * moment}
            best = minimize_scalar(energy, bounds=bounds, method='bounded', options=options)
            turns.append(best.x / moment)
        found.append(float(np.mean(turns)))
    assert found[0] == pytest.approx(faults.clamp_compliance, rel=0.02)
    assert found[1] > 1.2 * found[0]


def test_a_swing_in_putty_keeps_its_energy(
    setup: Setup, in_putty: tuple[Faults, Specimen]
) -> None:
    faults, specimen = in_putty
    check_a_swing_keeps_its_energy(specimen, setup, faults)


def test_a_body_in_putty_rests_lower_the_less_this_can_bear(
    setup: Setup, in_putty: tuple[Faults, Specimen]
) -> None:
    faults, specimen = in_putty
    firm, soft = (
        settle(specimen, setup, setup.observations[0], replace(faults, putty_give=give))
        for give in (50.0, 0.4)
    )
    up = setup.observations[0].world_from_object[1, :3]
    lower = (firm - soft)[specimen.shares > 0.99] @ up
    assert lower.min() > 2e-4


@pytest.mark.parametrize('step', STEPS)
def test_wadding_presses_by_its_energy(step: float) -> None:
    """Within its thickness and where it is as stiff as can be, and not above it."""
    normal = np.array([0.1, -0.3, np.sqrt(0.9)])
    law = wadding(np.array([30.0, 80.0, 50.0, 20.0, 60.0]), normal, 0.01, 0.05)
    deep = np.array([-0.004, 0.006, 0.021, 0.037, 0.046])
    across = np.random.default_rng(5).standard_normal((5, 3))
    across -= (across @ normal)[:, None] * normal
    places = (0.01 - deep)[:, None] * normal + 0.01 * across
    check_draws_by_its_energy(law, places, step)
    assert not law(places).gradient[0].any()


def test_wadding_presses_by_the_cube_of_how_densely_it_lies() -> None:
    normal, stiffness = np.array([0.0, 0.6, 0.8]), np.array([45.0])
    law = wadding(stiffness, normal, 0.0, 0.06)
    for deep in (0.001, 0.02, 0.04, 0.047):
        density = 0.06 / (0.06 - deep)
        push = 45.0 * 0.06 / 3.0 * (density**3 - 1.0)
        pushed = -law(-deep * normal[None]).gradient[0]
        np.testing.assert_allclose(pushed, push * normal, rtol=1e-9)
    # At first it is as stiff as told.
    first = -law(-1e-7 * normal[None]).gradient[0] @ normal
    assert first / 1e-7 == pytest.approx(45.0, rel=1e-4)


def test_a_body_comes_to_lie_on_wadding_with_its_lower_side(
    setup: Setup, specimen: Specimen, weight: np.ndarray, rest: np.ndarray
) -> None:
    up = setup.observations[0].world_from_object[1, :3]
    law = wadding_under(specimen, rest, up, WOOL)
    assert law(specimen.mesh.nodes).energy == 0.0
    pushed = law(rest).gradient
    is_touched = (pushed != 0.0).any(axis=1)
    assert specimen.shares[is_touched].min() >= 0.7
    assert (specimen.mesh.nodes[is_touched][:, 1:] @ up[1:]).max() < 0.0
    np.testing.assert_allclose(np.cross(pushed, up), 0.0, atol=1e-12)
    # What bears a part of the weight lets a body sag less.
    held = find_equilibrium(specimen.body, Load(weight, (law,)), specimen.mesh.nodes)
    higher = (held - rest)[specimen.shares > 0.99] @ up
    assert 1e-4 < higher.min() < higher.max() < 5e-3
    assert drawing(specimen, weight, WOOL)[0](rest).energy == pytest.approx(law(rest).energy)


def test_a_swing_on_wadding_keeps_its_energy(
    setup: Setup, specimen: Specimen, weight: np.ndarray
) -> None:
    laws = drawing(specimen, weight, replace(WOOL, wool_top=0.1))
    whole, drawn = energies_of_a_swing(specimen, setup, weight, laws, 0.08)
    assert len(laws) == 1
    assert drawn[0] == 0.0
    assert drawn.max() > 1e-6
    assert np.ptp(whole) < 0.1 * drawn.max()


_MOVING = [key for key in FORMS if not key.startswith(('time', 'camera'))]


@pytest.mark.slow
@pytest.mark.parametrize('key', _MOVING)
def test_sizes_are_seen_and_the_large_one_is_about_twice_the_medium_one(key: str) -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    is_slow = key.startswith(('creep', 'added'))
    timing = (draw_hold if is_slow else draw_swing)(np.random.default_rng(2))
    moves = moves_by_size(drawn, FORMS[key].effect, replace(timing, frame_count=15))
    assert 1.0 < moves[0] < 7.0
    assert 1.4 < moves[1] / moves[0] < 3.2
