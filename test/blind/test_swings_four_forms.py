# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies, jaws, tables and air of the set `swings_four` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from support.blind_draws import STEPS
from support.blind_swings import (
    check_draws_by_its_energy,
    compliance,
    energies_of_a_swing,
    moves_by_size,
    soft_beam,
)

from benchmarks.blind.balls import balls, balls_under
from benchmarks.blind.clamps import lining
from benchmarks.blind.creep import held_load
from benchmarks.blind.drag import AIR, make_drag, make_tuft
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import dashpots, drawing, positions_at
from benchmarks.blind.relaxation import material_times, prony_pairs
from benchmarks.blind.rig_motion import leaned, toppled
from benchmarks.blind.rotations import about, applied, rotation
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.swing import consistent_masses, Forces, swing
from benchmarks.blind.swings_four_forms import SWINGS_FOUR_FORMS
from benchmarks.blind.timing import draw_hold, draw_swing
from benchmarks.blind.unrolling import bent, left_bend

FORMS = {form.key: form for form in SWINGS_FOUR_FORMS}
SETTING = Faults(creep_form='setting', creep_share=0.3, creep_time=5.0, creep_set=7.0)
TOPPLING = Faults(tilt_form='toppling', gravity_tilt=(14.0, -5.0), tilt_time=0.06, tilt_fall=0.15)
BALLS = Faults(balls=2000.0, balls_from=0.7, balls_top=0.7)
BEND = Faults(curvature_form='unrolling', rest_curvature=(0.8, -1.1), curvature_time=6.0)


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
def in_gel(setup: Setup) -> tuple[Faults, Specimen]:
    """Return a body in gel, and what is wrong with that."""
    faults = Faults(clamp_form='gel', clamp_compliance=1.5, clamp_time=0.02)
    return faults, make_specimen(setup, faults, refinement=0.5)


def test_a_tuft_drags_by_the_square_and_by_four_thirds_where_it_is_bent(
    specimen: Specimen,
) -> None:
    tuft = make_tuft(0.02, 0.8, 0.3, specimen.areas, specimen.shares)
    way = np.array([0.36, -0.48, 0.8])

    def felt(speed: float) -> np.ndarray:
        return tuft.forces(np.tile(speed * way, (len(specimen.shares), 1)))

    for speed, power in ((1e-3, 2.0), (300.0, 4.0 / 3.0)):
        one, two = (np.linalg.norm(felt(each).sum(axis=0)) for each in (speed, 1.01 * speed))
        assert np.log(two / one) / np.log(1.01) == pytest.approx(power, abs=1e-3)
    slow = 0.5 * AIR * 0.02 * 1e-6 * way
    np.testing.assert_allclose(felt(1e-3).sum(axis=0), slow, rtol=1e-4)
    bent_by = 0.5 * AIR * 0.02 * 0.09 / 2.0 ** (1.0 / 3.0) * way
    np.testing.assert_allclose(felt(0.3).sum(axis=0), bent_by, rtol=1e-9)
    share = np.linalg.norm(felt(0.5), axis=1)
    assert share @ specimen.shares / share.sum() == pytest.approx(0.8, abs=0.03)


@pytest.mark.parametrize('step', STEPS)
def test_a_tufts_drag_is_the_slope_of_its_potential_by_the_speed(
    specimen: Specimen, step: float
) -> None:
    """That is the integral over the speed at each node: of s^2 (1 + (s / b)^2)^(-1/3)."""
    tuft = make_tuft(0.03, 0.75, 0.4, specimen.areas, specimen.shares)
    random = np.random.default_rng(1)
    speeds = random.uniform(-1.0, 1.0, (len(specimen.shares), 3))
    move = random.standard_normal(speeds.shape)
    felt = np.flatnonzero(tuft.weights)

    def potential(sizes: np.ndarray) -> np.ndarray:
        found = [quad(lambda s: s**2 / np.cbrt(1.0 + (s / 0.4) ** 2), 0.0, u)[0] for u in sizes]
        return tuft.weights[felt] * np.array(found)

    one, two = (
        potential(np.linalg.norm(speeds[felt] + way * step * move[felt], axis=1))
        for way in (1.0, -1.0)
    )
    slopes = (tuft.forces(speeds)[felt] * move[felt]).sum(axis=1)
    assert np.abs((one - two) / (2.0 * step) - slopes).max() < 1e-4 * np.abs(slopes).max()
    assert len(felt) > 4
    assert (tuft.forces(speeds) * speeds).sum(axis=1).min() >= 0.0


def test_a_body_with_a_tuft_swings_less_far(setup: Setup, specimen: Specimen) -> None:
    timing, view = draw_swing(np.random.default_rng(2)), setup.observations[0]
    stiff = Faults(drag_form='tuft', drag_area=15000.0, drag_at=0.9, drag_bends=1e3)
    end, up = specimen.shares > 0.99, view.world_from_object[1, :3]
    heights = [
        float((positions_at(specimen, setup, view, each, timing, [0.05])[0][end] @ up).mean())
        for each in (Faults(), replace(stiff, drag_bends=0.2), stiff)
    ]
    # Bristles that do not bend drag more.
    assert heights[0] + 1e-4 < heights[1]
    assert heights[1] + 1e-4 < heights[2]


@pytest.mark.parametrize('step', [1e-2, 1e-3, 1e-4])
def test_a_body_that_sets_relaxes_slower_and_slower(step: float) -> None:
    for time in (0.5, 6.0, 30.0):
        one, other = material_times(SETTING, [time + step, time - step])
        assert (one - other) / (2.0 * step) == pytest.approx(np.exp(-time / 7.0), rel=1e-4)
    assert material_times(SETTING, [0.0, 1e3]) == pytest.approx([0.0, 7.0])
    assert material_times(replace(SETTING, creep_form='one'), [3.0, 20.0]) == [3.0, 20.0]


def test_a_body_that_sets_creeps_as_its_rate_equation_says_and_stops(specimen: Specimen) -> None:
    """Of a standard solid whose relaxation time grows: a spring beside one with a dashpot."""
    share = specimen.shares[specimen.body.cells] @ specimen.body.quadrature.values.T
    when = np.array([1.0, 5.0, 12.0, 34.0, 60.0])
    load = Load(specimen.body.masses[:, None] * np.array([0.0, 0.0, -0.01 * GRAVITY]))
    nodes = specimen.mesh.nodes
    elastic = find_equilibrium(specimen.body, load, nodes) - nodes
    own = material_times(SETTING, when)
    pairs = prony_pairs(SETTING, share)
    held = held_load(specimen.body, load, nodes, own, pairs)
    found = [float(((one - nodes) * elastic).sum() / (elastic**2).sum()) for one in held]

    def rate(time: float, strain: np.ndarray) -> np.ndarray:
        # What the dashpot's spring bears falls by its own time, as the strain draws it out.
        return (1.0 / 0.7 - strain) * 0.7 * np.exp(-time / 7.0) / 5.0

    grown = solve_ivp(rate, (0.0, 60.0), [1.0], t_eval=when, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(found, grown.y[0], rtol=1e-3)
    np.testing.assert_allclose(found, compliance([(0.3, 5.0)], np.array(own)), rtol=1e-3)
    # It never comes to where one that does not set would.
    assert found[-1] - found[-2] < 2e-3
    assert found[-1] < 1.0 / 0.7 - 0.1


def test_a_setting_body_is_filmed_where_its_own_time_has_come(
    setup: Setup, specimen: Specimen
) -> None:
    timing, view = draw_hold(np.random.default_rng(2)), setup.observations[0]
    found = positions_at(specimen, setup, view, SETTING, timing, [2.0, 9.0])
    usual = replace(SETTING, creep_form='one')
    own = material_times(SETTING, [2.0, 9.0])
    later = positions_at(specimen, setup, view, usual, timing, own)
    np.testing.assert_allclose(found, later, atol=1e-12)
    as_late = positions_at(specimen, setup, view, usual, timing, [2.0, 9.0])
    assert np.abs(found[1] - as_late[1]).max() > 3e-4


@pytest.mark.parametrize('step', [1e-3, 3e-4, 1e-4])
def test_a_table_topples_as_a_pendulum_upside_down(step: float) -> None:
    """Its turn is driven away by itself and by the little it began with."""
    for time in (0.02, 0.07, 0.13):
        one, two, three = (toppled(TOPPLING, time + k * step) for k in (-1, 0, 1))
        begun = 1.0 / (np.cosh(0.15 / 0.06) - 1.0)
        driven = (two + begun) / 0.06**2
        assert (one - 2.0 * two + three) / step**2 == pytest.approx(driven, rel=1e-3)
    assert toppled(TOPPLING, 0.0) == 0.0
    assert toppled(TOPPLING, step) < 0.1 * step / 0.15
    assert toppled(TOPPLING, 0.15) == pytest.approx(1.0)
    assert toppled(TOPPLING, 0.4) == toppled(TOPPLING, 0.15)


def test_a_table_that_has_toppled_leans_by_its_tilt() -> None:
    assert not leaned(TOPPLING, -0.1).any()
    assert not leaned(TOPPLING, 0.0).any()
    down = np.array([0.0, -GRAVITY, 0.0])
    # About the world's x and z by Rodrigues' formula.
    x, z = np.deg2rad(TOPPLING.gravity_tilt)
    turn = np.array([x, 0.0, z])
    angle = float(np.linalg.norm(turn))
    axis = turn / angle
    turned = down * np.cos(angle) + np.cross(axis, down) * np.sin(angle)
    turned = turned + axis * (axis @ down) * (1.0 - np.cos(angle))
    np.testing.assert_allclose(leaned(TOPPLING, 0.3) + down, turned, atol=1e-12)
    # On its way it has turned by a part of that about the same axis.
    part = down + leaned(TOPPLING, 0.1)
    cosine = part @ down / GRAVITY**2
    share = toppled(TOPPLING, 0.1)
    assert 0.1 < share < 0.6
    assert np.arccos(cosine) == pytest.approx(share * angle, rel=1e-6)


def test_a_body_swings_to_where_a_toppling_table_leans(setup: Setup, specimen: Specimen) -> None:
    timing, view = draw_swing(np.random.default_rng(2)), setup.observations[0]
    times, end = [-0.1, 0.01, 0.12], specimen.shares > 0.99
    quiet, *ways = (
        np.array(positions_at(specimen, setup, view, each, timing, times))
        for each in (
            Faults(),
            replace(TOPPLING, gravity_tilt=(20.0, 0.0)),
            replace(TOPPLING, gravity_tilt=(-20.0, 0.0)),
        )
    )
    for tilted, tilt in zip(ways, (20.0, -20.0), strict=True):
        moved = (tilted - quiet)[:, end].mean(axis=1)
        assert not moved[0].any()
        assert np.abs(moved[1]).max() < 1e-5
        way = view.world_from_object[:3, :3].T @ leaned(
            replace(TOPPLING, gravity_tilt=(tilt, 0)), 1
        )
        assert moved[2] @ way / np.linalg.norm(way) > 2e-4


@pytest.mark.parametrize('step', STEPS)
def test_gels_springs_draw_by_their_energy(in_gel: tuple[Faults, Specimen], step: float) -> None:
    faults, specimen = in_gel
    law = lining(specimen, specimen.mesh.nodes, faults)
    moved = np.random.default_rng(1).uniform(-4e-3, 5e-3, specimen.mesh.nodes.shape)
    check_draws_by_its_energy(law, specimen.mesh.nodes + moved, step)


def test_a_rigid_body_comes_to_its_turn_in_gel_by_the_exponential(
    in_gel: tuple[Faults, Specimen],
) -> None:
    """Springs' moment by a turn and dashpots' by its rate, summed over the nodes."""
    faults, specimen = in_gel
    nodes, held = specimen.mesh.nodes, dashpots(specimen, faults)
    law = lining(specimen, nodes, faults)
    assert held is not None
    assert not held[specimen.shares > 0.0].any()
    assert dashpots(specimen, replace(faults, clamp_form='boot')) is None
    turns = []
    for axis in np.eye(3)[1:]:
        arms = np.cross(axis, nodes - specimen.center)
        back = float((held[:, None] * arms**2).sum())
        turned = applied(about(rotation(1e-5 * axis), specimen.center, np.zeros(3)), nodes)
        stiff = float((law(turned).gradient * arms).sum()) / 1e-5
        assert back / stiff == pytest.approx(0.02, rel=1e-3)
        turns.append(1.0 / stiff)
    assert np.mean(turns) == pytest.approx(1.5, rel=0.02)


def test_what_a_swing_in_gel_loses_goes_with_the_square_of_the_speed(
    setup: Setup, in_gel: tuple[Faults, Specimen]
) -> None:
    faults, specimen = in_gel
    weight = specimen.body.masses[:, None] * np.array([0.0, 0.0, -GRAVITY])
    laws, held = drawing(specimen, weight, faults), dashpots(specimen, faults)
    assert held is not None
    own = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    air = make_drag(specimen.mesh, 0.0)
    forces = Forces(weight, 0.0, air, setup.youngs_modulus, None, laws, held)
    step, start = 0.02 / 60.0, specimen.mesh.nodes
    path = swing(specimen.body, own, forces, start, step * np.arange(1, 61), step)
    steps = [(two - one) / step for one, two in zip((start, *path[:-1]), path, strict=True)]
    lost = step * sum(float(held @ (each**2).sum(axis=1)) for each in steps)

    def whole(place: np.ndarray, speed: np.ndarray) -> float:
        local = speed[specimen.body.cells]
        moving = 0.5 * float(np.einsum('cai,cab,cbi', local, own, local))
        still = specimen.body.evaluate(place, with_stiffness=False).energy
        return moving + still + laws[0](place).energy - float((weight * place).sum())

    # Speeds of steps are those of their middles.
    last = 0.5 * (path[-1] + path[-2])
    left = whole(start, 0.0 * start) - whole(last, steps[-1])
    final = 0.5 * step * float(held @ (steps[-1] ** 2).sum(axis=1))
    assert left == pytest.approx(lost - final, rel=0.03)
    assert lost > 1e-6


def test_gel_gives_way_later_than_a_boot_and_as_far(
    setup: Setup, in_gel: tuple[Faults, Specimen]
) -> None:
    faults, specimen = in_gel
    timing, view = draw_swing(np.random.default_rng(2)), setup.observations[0]
    near = (np.abs(specimen.shares) < 0.1) & (specimen.mesh.lattice[:, 0] > specimen.center[0])
    up = view.world_from_object[1, :3]
    gel, boot = (
        np.array(positions_at(specimen, setup, view, each, timing, [0.03, 0.06]))[:, near] @ up
        for each in (replace(faults, clamp_time=0.15), replace(faults, clamp_form='boot'))
    )
    gone = (specimen.mesh.nodes[near] @ up - boot).mean(axis=1)
    later = (specimen.mesh.nodes[near] @ up - gel).mean(axis=1)
    assert 0.0 < later[0] < 0.6 * gone[0]
    assert later[1] > later[0]


@pytest.mark.parametrize('step', STEPS)
def test_balls_press_by_their_energy(step: float) -> None:
    normal = np.array([0.1, -0.3, np.sqrt(0.9)])
    law = balls(np.array([300.0, 800.0, 500.0, 200.0]), normal, 0.01)
    deep = np.array([-0.004, 0.006, 0.021, 0.012])
    across = np.random.default_rng(5).standard_normal((4, 3))
    across -= (across @ normal)[:, None] * normal
    places = (0.01 - deep)[:, None] * normal + 0.01 * across
    check_draws_by_its_energy(law, places, step)
    assert not law(places).gradient[0].any()


def test_a_ball_presses_as_hertz_found() -> None:
    normal, stiffness = np.array([0.0, 0.6, 0.8]), np.array([450.0])
    law = balls(stiffness, normal, 0.002)
    for deep in (1e-4, 1e-3, 9e-3):
        pushed = -law((0.002 - deep) * normal[None]).gradient[0]
        np.testing.assert_allclose(pushed, 450.0 * deep**1.5 * normal, rtol=1e-9)
        work = quad(lambda d: 450.0 * d**1.5, 0.0, deep)[0]
        assert law((0.002 - deep) * normal[None]).energy == pytest.approx(work)


def test_a_body_comes_to_lie_on_balls_with_its_lower_side(
    setup: Setup, specimen: Specimen, weight: np.ndarray, rest: np.ndarray
) -> None:
    up = setup.observations[0].world_from_object[1, :3]
    law = balls_under(specimen, rest, up, BALLS)
    assert law(specimen.mesh.nodes).energy == 0.0
    pushed = law(rest).gradient
    is_touched = (pushed != 0.0).any(axis=1)
    assert specimen.shares[is_touched].min() >= 0.7
    assert (specimen.mesh.nodes[is_touched][:, 1:] @ up[1:]).max() < 0.0
    np.testing.assert_allclose(np.cross(pushed, up), 0.0, atol=1e-12)
    held = find_equilibrium(specimen.body, Load(weight, (law,)), specimen.mesh.nodes)
    higher = (held - rest)[specimen.shares > 0.99] @ up
    assert 1e-4 < higher.min() < higher.max() < 8e-3
    assert drawing(specimen, weight, BALLS)[0](rest).energy == pytest.approx(law(rest).energy)


def test_a_swing_on_balls_keeps_its_energy(
    setup: Setup, specimen: Specimen, weight: np.ndarray
) -> None:
    laws = drawing(specimen, weight, replace(BALLS, balls_top=0.1))
    whole, drawn = energies_of_a_swing(specimen, setup, weight, laws, 0.08)
    assert len(laws) == 1
    assert drawn[0] == 0.0
    assert drawn.max() > 1e-6
    assert np.ptp(whole) < 0.1 * drawn.max()


@pytest.mark.parametrize('step', [1e-2, 1e-3, 1e-4])
def test_a_bend_goes_by_the_square_of_what_is_left_of_it(step: float) -> None:
    for time in (0.5, 6.0, 30.0):
        slope = (left_bend(BEND, time + step) - left_bend(BEND, time - step)) / (2.0 * step)
        assert slope == pytest.approx(-(left_bend(BEND, time) ** 2) / 6.0, rel=1e-4)
    assert left_bend(BEND, 6.0) == pytest.approx(0.5)
    assert left_bend(BEND, -3.0) == 1.0


def test_a_bent_body_without_a_load_is_an_arc(setup: Setup, specimen: Specimen) -> None:
    """Its end is off by half of the bend times the square of the free length, either way."""
    free = setup.shape.length - setup.shape.clamp
    for share in (1.0, 0.4):
        milder = bent(specimen, setup, BEND, share)
        place = find_equilibrium(milder.body, Load(0.0 * specimen.mesh.nodes), specimen.mesh.nodes)
        moved = (place - specimen.mesh.nodes)[specimen.shares > 0.999].mean(axis=0)
        # A turn about y takes what is ahead down, one about z to the side.
        expected = 0.5 * share * free**2 * np.array([-1.1, -0.8])
        np.testing.assert_allclose(moved[1:], expected, rtol=0.02)


def test_a_body_unrolls_from_its_bend_to_where_a_straight_one_rests(
    setup: Setup, weight: np.ndarray, rest: np.ndarray
) -> None:
    timing, view = draw_hold(np.random.default_rng(2)), setup.observations[0]
    rolled = make_specimen(setup, BEND, refinement=0.5)
    times = [-1.0, 1e-6, 6.0, 40.0, 1e9]
    lying, *found = positions_at(rolled, setup, view, BEND, timing, times)
    end = rolled.shares > 0.999
    np.testing.assert_allclose(lying[end], rolled.mesh.nodes[end], atol=1e-12)
    away = [float(np.linalg.norm((place - rest)[end].mean(axis=0))) for place in found]
    assert np.diff(away).max() < -2e-4
    np.testing.assert_allclose(found[-1], rest, atol=4e-6)
    whole = find_equilibrium(rolled.body, Load(weight), rolled.mesh.nodes)
    np.testing.assert_allclose(found[0], whole, atol=4e-6)
    # Half of it after its time: as a body that is made with half the bend.
    half = replace(BEND, rest_curvature=(0.4, -0.55))
    made = make_specimen(setup, half, refinement=0.5)
    there = find_equilibrium(made.body, Load(weight), made.mesh.nodes)
    np.testing.assert_allclose(found[1], there, atol=4e-6)


_MOVING = [key for key in FORMS if not key.startswith(('time', 'depth'))]


@pytest.mark.slow
@pytest.mark.parametrize('key', _MOVING)
def test_sizes_are_seen_and_the_large_one_is_about_twice_the_medium_one(key: str) -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    is_slow = key.startswith(('creep', 'rest'))
    timing = (draw_hold if is_slow else draw_swing)(np.random.default_rng(2))
    count = 22 if is_slow else 15
    moves = moves_by_size(drawn, FORMS[key].effect, replace(timing, frame_count=count), 0.6)
    assert 2.0 < moves[0] < 7.0
    assert 1.4 < moves[1] / moves[0] < 3.2
