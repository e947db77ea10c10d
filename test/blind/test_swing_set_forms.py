# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Air, rubber, masses and tables of the set `swings` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_swings import compliance, moves_by_size, soft_beam

from benchmarks.blind.creep import held_load
from benchmarks.blind.drag import AIR, Drag, make_drag, make_sail
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import end_lumps
from benchmarks.blind.relaxation import Pair, power_pairs, prony_pairs
from benchmarks.blind.rig_motion import acting, leaned
from benchmarks.blind.rubber import draw_rubber
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.swing import consistent_masses, Forces, swing, with_lumps
from benchmarks.blind.swing_set_forms import SWING_SET_FORMS
from benchmarks.blind.swing_set_outside import first_rate, first_sag, SOFTER
from benchmarks.blind.timing import draw_hold, draw_swing

FORMS = {form.key: form for form in SWING_SET_FORMS}


@pytest.fixture(scope='module')
def setup() -> Setup:
    return soft_beam()


@pytest.fixture(scope='module')
def specimen(setup: Setup) -> Specimen:
    return make_specimen(setup, Faults(), refinement=0.5)


def _light(specimen: Specimen, part: float = 0.01) -> Load:
    """Return so little of the weight across the body that all is linear."""
    down = np.array([0.0, 0.0, -part * GRAVITY])
    return Load(specimen.body.masses[:, None] * down)


def test_a_thin_layer_drags_by_the_power_of_one_and_a_half(specimen: Specimen) -> None:
    square, laminar = (make_drag(specimen.mesh, 0.1, form) for form in ('square', 'laminar'))
    way = np.tile([0.3, -0.4, 0.0], (len(specimen.mesh.nodes), 1))
    total = laminar.forces(way).sum(axis=0)
    # As much at half a metre per second, along the motion.
    np.testing.assert_allclose(total, square.forces(way).sum(axis=0), rtol=1e-9)
    np.testing.assert_allclose(total, 0.05 * AIR * 0.25 * np.array([0.6, -0.8, 0.0]), atol=1e-9)
    faster = laminar.forces(4.0 * way).sum(axis=0)
    np.testing.assert_allclose(faster, 8.0 * total, rtol=1e-9)
    assert not laminar.forces(0.0 * way).any()


def test_a_sail_is_pressed_across_its_face_where_it_is(specimen: Specimen) -> None:
    sail = make_sail(0.02, 0.8, specimen.body.masses, specimen.shares)
    aslant = sail.forces(np.tile([0.1, 0.7, -0.3], (len(specimen.shares), 1)))
    assert not aslant[:, :2].any()
    assert aslant[:, 2].sum() == pytest.approx(-0.5 * AIR * 0.02 * 0.3**2)
    felt = np.abs(aslant[:, 2])
    assert felt @ specimen.shares / felt.sum() == pytest.approx(0.8, abs=0.03)
    assert (np.abs(specimen.shares[felt > 0.0] - 0.8) < 0.1).all()


@pytest.mark.slow
@pytest.mark.parametrize('form', ['laminar', 'sail'])
def test_air_takes_as_much_energy_as_its_power_says(
    setup: Setup, specimen: Specimen, form: str
) -> None:
    """What a body has less of, with the air than without, is the integral of force by speed."""
    masses = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    weight = specimen.body.masses[:, None] * np.array([0.0, 0.0, -GRAVITY])
    step = 1.0 / 1200.0
    times = step * np.arange(1, 61)
    drag = make_drag(specimen.mesh, 2.0, form)
    if form == 'sail':
        drag = make_sail(1.0, 0.8, specimen.body.masses, specimen.shares)

    def energies(air: Drag) -> tuple[np.ndarray, np.ndarray]:
        forces = Forces(weight, 0.0, air, 6.0e5)
        start = specimen.mesh.nodes
        path = np.array([start, *swing(specimen.body, masses, forces, start, times, step)])
        rates, found, powers = np.diff(path, axis=0) / step, [], []
        for rate, one, two in zip(rates, path[:-1], path[1:], strict=True):
            local = rate[specimen.body.cells]
            moving = 0.5 * float(np.einsum('cai,cab,cbi', local, masses, local))
            middle = 0.5 * (one + two)
            still = specimen.body.evaluate(middle, with_stiffness=False).energy
            found.append(moving + still - float((weight * middle).sum()))
            powers.append(float((drag.forces(rate) * rate).sum()))
        return np.array(found), np.array(powers)

    none = make_drag(specimen.mesh, 0.0)
    free, _ = energies(none)
    held, powers = energies(drag)
    lost, spent = free[-1] - held[-1], step * (powers.sum() - 0.5 * powers[-1])
    assert lost > 3e-5
    assert lost == pytest.approx(spent, rel=0.03)


def test_pairs_of_a_power_law_are_that_law() -> None:
    times = np.geomspace(0.2, 40.0, 60)
    for time, power in ((0.3, 0.25), (0.6, 0.35), (1.0, 0.45)):
        pairs = power_pairs(0.4, time, power)
        left = sum(share for share, _ in pairs)
        found = 1.0 - left + sum(share * np.exp(-times / tau) for share, tau in pairs)
        law = (1.0 + times / time) ** -power
        # A part that relaxes within milliseconds, or in hours, is not seen.
        parts = np.stack([np.ones(60), found], axis=1)
        fitted = parts @ np.linalg.lstsq(parts, law, rcond=None)[0]
        assert np.abs(fitted - law).max() < 3e-3
        assert np.abs(found - found[0] - 0.4 * (law - law[0])).max() < 4e-3


@pytest.mark.parametrize('form', ['power', 'flowing'])
def test_a_light_load_creeps_as_the_compliance_of_its_law_says(
    specimen: Specimen, form: str
) -> None:
    faults = {
        'power': Faults(creep_form='power', creep_share=0.4, creep_time=0.6, creep_power=0.35),
        'flowing': Faults(creep_form='flowing', creep_share=1.0, creep_time=60.0),
    }[form]
    share = specimen.shares[specimen.body.cells] @ specimen.body.quadrature.values.T
    pairs = prony_pairs(faults, share)
    times = np.array([0.5, 2.5, 8.5, 20.5])
    load, rest = _light(specimen), specimen.mesh.nodes
    elastic = find_equilibrium(specimen.body, load, rest) - rest
    held = held_load(specimen.body, load, rest, times, pairs, is_graded=form == 'power')
    found = [float(((one - rest) * elastic).sum() / (elastic**2).sum()) for one in held]
    np.testing.assert_allclose(found, compliance(pairs, times), rtol=0.01)
    assert found[-1] > 1.2


def test_what_has_no_network_flows_evenly(specimen: Specimen) -> None:
    load, rest = _light(specimen), specimen.mesh.nodes
    held = held_load(specimen.body, load, rest, [1e-6, 15.0, 30.0], [(1.0, 60.0)])
    sag = [float(-(one - rest)[:, 2].min()) for one in held]
    assert sag[1] / sag[0] == pytest.approx(1.25, rel=2e-3)
    assert sag[2] / sag[0] == pytest.approx(1.50, rel=4e-3)


def test_steps_that_grow_with_the_time_find_the_same(specimen: Specimen) -> None:
    load = Load(specimen.body.masses[:, None] * np.array([0.0, 0.0, -GRAVITY]))
    pairs: list[Pair] = [(0.15, 0.3), (0.15, 4.0)]
    graded, even = (
        held_load(specimen.body, load, specimen.mesh.nodes, [0.5, 2.5, 4.5], pairs, is_graded=each)
        for each in (True, False)
    )
    crept = np.linalg.norm(even[-1] - even[0])
    for one, two in zip(graded, even, strict=True):
        assert np.linalg.norm(one - two) < 0.01 * crept


def test_a_pour_near_the_clamp_creeps_alone(specimen: Specimen) -> None:
    """At last it is as if that were softer, and all else as it was."""
    faults = Faults(creep_form='pour', creep_share=0.4, creep_time=2.0, creep_until=0.45)
    share = specimen.shares[specimen.body.cells] @ specimen.body.quadrature.values.T
    load = Load(specimen.body.masses[:, None] * np.array([0.1, 0.0, -GRAVITY]))
    pairs = prony_pairs(faults, share)
    last = held_load(specimen.body, load, specimen.mesh.nodes, [40.0], pairs)[0]
    numbers, left = specimen.body.numbers, 1.0 - 0.4 * (share < 0.45)
    softer = replace(numbers, shear=left * numbers.shear, bulk=left * numbers.bulk)
    body = replace(specimen.body, numbers=softer)
    relaxed = find_equilibrium(body, load, specimen.mesh.nodes)
    sag = find_equilibrium(specimen.body, load, specimen.mesh.nodes)
    size = np.abs(relaxed - sag).max()
    assert size > 2e-3
    assert np.abs(last - relaxed).max() < 0.01 * size


@pytest.mark.parametrize('law', ['plain', 'fibres', 'mooney'])
def test_bodies_of_all_laws_creep_to_the_equilibrium_of_what_is_left(
    setup: Setup, law: str
) -> None:
    """All stresses fall alike: as under a load that is larger by that."""
    made = replace(setup, rubber=draw_rubber(law, np.random.default_rng(4)))
    body = make_specimen(made, Faults(), refinement=0.5).body
    rest = make_specimen(made, Faults(), refinement=0.5).mesh.nodes
    weight = body.masses[:, None] * np.array([0.0, 0.0, -0.7 * GRAVITY])
    first, last = held_load(body, Load(weight), rest, [1e-6, 40.0], [(0.3, 2.0)])
    np.testing.assert_allclose(first, find_equilibrium(body, Load(weight), rest), atol=1e-6)
    heavier = find_equilibrium(body, Load(weight / 0.7), rest)
    size = np.abs(heavier - first).max()
    assert size > 1e-3
    assert np.abs(last - heavier).max() < 0.01 * size


def test_an_end_plate_is_as_heavy_as_told_and_moves_with_the_end(
    setup: Setup, specimen: Specimen
) -> None:
    lumps = end_lumps(specimen, setup, Faults(end_mass=1.5))
    assert lumps.sum() == pytest.approx(1.5e-3)
    middle = lumps @ specimen.mesh.nodes / lumps.sum()
    np.testing.assert_allclose(middle, [setup.shape.length, 0.0, 0.0], atol=1e-9)
    assert np.ptp(specimen.mesh.nodes[lumps > 0.0, 0]) < 1e-9
    bare = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    laden = with_lumps(bare, specimen.body, lumps)
    rate = specimen.mesh.nodes**2 + 0.1
    local = rate[specimen.body.cells]
    more = np.einsum('cai,cab,cbi', local, laden - bare, local)
    assert more == pytest.approx(float((lumps[:, None] * rate**2).sum()), rel=1e-9)


def test_a_body_with_an_end_plate_sags_as_a_bar_with_a_load_on_its_end(
    setup: Setup, specimen: Specimen
) -> None:
    """By eight thirds of its share in the mass, of the sag by that, shear aside."""
    mass = setup.density * np.prod(setup.shape.section)
    mass *= setup.shape.length - setup.shape.clamp
    lumps, rest = (
        end_lumps(specimen, setup, Faults(end_mass=0.1 * 1e3 * mass)),
        specimen.mesh.nodes,
    )
    down = np.array([0.0, 0.0, -0.01 * GRAVITY])
    sags = [
        float(
            (rest - find_equilibrium(specimen.body, Load(masses[:, None] * down), rest))[
                :, 2
            ].max()
        )
        for masses in (specimen.body.masses, specimen.body.masses + lumps)
    ]
    assert sags[1] / sags[0] - 1.0 == pytest.approx(0.1 * 8.0 / 3.0, rel=0.05)


def test_guesses_of_a_bodys_swing_are_those_of_an_even_bar(setup: Setup) -> None:
    specimen = make_specimen(replace(setup, youngs_modulus=SOFTER * 6.0e5), Faults())
    down = np.array([0.0, 0.0, -0.01 * GRAVITY])
    width, height = setup.shape.section
    flat = down if height < width else down[[0, 2, 1]]
    load, rest = Load(specimen.body.masses[:, None] * flat), specimen.mesh.nodes
    sag = 100.0 * float(np.abs(find_equilibrium(specimen.body, load, rest) - rest).max())
    assert first_sag(setup) == pytest.approx(sag, rel=0.12)
    assert first_rate(setup) == pytest.approx(np.sqrt(1.545 * GRAVITY / sag), rel=0.08)


def test_a_table_leans_over_from_the_release_on(setup: Setup) -> None:
    faults = Faults(tilt_form='yielding', gravity_tilt=(12.0, -5.0), tilt_time=0.05)
    assert not leaned(faults, -0.1).any()
    assert not leaned(faults, 0.0).any()
    down = np.array([0.0, -GRAVITY, 0.0])
    at_last = leaned(faults, 10.0) + down
    assert np.linalg.norm(at_last) == pytest.approx(GRAVITY)
    assert at_last @ down / GRAVITY**2 == pytest.approx(np.cos(np.deg2rad(13.0)))
    # About x, what is below goes to the back; about z, to the right.
    assert at_last[2] == pytest.approx(-GRAVITY * np.sin(np.deg2rad(12.0)), rel=0.02)
    assert at_last[0] == pytest.approx(-GRAVITY * np.sin(np.deg2rad(5.0)), rel=0.02)
    # What is left of the angle falls by the same share in equal times.
    left = [
        13.0 - np.rad2deg(2.0 * np.arcsin(np.linalg.norm(leaned(faults, t)) / 2.0 / GRAVITY))
        for t in (0.0, 0.03, 0.06, 0.09)
    ]
    np.testing.assert_allclose(np.diff(np.log(left)), -0.03 / 0.05, rtol=1e-6)


def test_what_acts_is_a_load_like_any_other(setup: Setup, specimen: Specimen) -> None:
    """A table that leaned over at once is gravity that stands aslant."""
    observation, masses = setup.observations[0], specimen.body.masses
    faults = Faults(tilt_form='yielding', gravity_tilt=(12.0, 0.0), tilt_time=1e-9)
    down = observation.world_from_object[:3, :3].T @ np.array([0.0, -GRAVITY, 0.0])
    own = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    still = make_drag(specimen.mesh, 0.0)
    changing = acting(observation, faults, masses, np.zeros(len(masses)))
    aslant = observation.world_from_object[:3, :3].T @ leaned(faults, 1.0)
    one, two = (
        swing(
            specimen.body,
            own,
            Forces(masses[:, None] * pull, 20.0, still, 6.0e5, more),
            specimen.mesh.nodes,
            [0.05],
            1.0 / 600.0,
        )[0]
        for pull, more in ((down, changing), (down + aslant, None))
    )
    # But for half of the first step, at whose beginning it had not leaned over.
    moved = np.abs(two - specimen.mesh.nodes).max()
    assert moved > 5e-3
    assert np.abs(one - two).max() < 0.02 * moved


def test_without_such_effects_nothing_acts(setup: Setup, specimen: Specimen) -> None:
    masses = specimen.body.masses
    assert acting(setup.observations[0], Faults(drag_area=3.0), masses, 0.0 * masses) is None


@pytest.mark.slow
@pytest.mark.parametrize('key', [key for key in FORMS if not key.startswith('time_offset')])
def test_sizes_are_seen_and_the_large_one_is_about_twice_the_medium_one(key: str) -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    timing = (draw_hold if key.startswith('creep') else draw_swing)(np.random.default_rng(2))
    moves = moves_by_size(drawn, FORMS[key].effect, replace(timing, frame_count=15))
    assert 1.0 < moves[0] < 7.0
    assert 1.5 < moves[1] / moves[0] < 3.2
