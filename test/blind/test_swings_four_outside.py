# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library of the set `swings_four` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_draws import STEPS
from support.blind_swings import moves_by_size, soft_beam

from benchmarks.blind.drag import make_drag
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import positions_at
from benchmarks.blind.remanence import with_remanence
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.swing import consistent_masses, Forces, swing
from benchmarks.blind.swings_four_outside import SWINGS_FOUR_OUTSIDE
from benchmarks.blind.tearing import torn, torn_share, WIDE
from benchmarks.blind.timing import draw_swing

PULL = Faults(remanent=0.02, remanent_time=0.1, remanent_way=(0.0, 0.6, -0.8))
TEARS = Faults(tearing=1.4, tearing_at=0.15, tearing_time=0.03)


@pytest.fixture(scope='module')
def setup() -> Setup:
    return soft_beam()


@pytest.fixture(scope='module')
def specimen(setup: Setup) -> Specimen:
    return make_specimen(setup, Faults(), refinement=0.5)


@pytest.fixture(scope='module')
def end(specimen: Specimen) -> np.ndarray:
    is_there = specimen.shares > 1.0 - 1e-9
    return is_there / np.count_nonzero(is_there)


@pytest.mark.parametrize('step', STEPS)
def test_a_magnets_pull_is_the_slope_of_its_work(
    specimen: Specimen, end: np.ndarray, step: float
) -> None:
    """Of the mean move of the end face along its way: all else feels nothing."""
    changing = with_remanence(None, end, PULL)
    assert changing is not None
    pulled = changing(0.05)
    move = np.random.default_rng(3).standard_normal(specimen.mesh.nodes.shape)

    def work(places: np.ndarray) -> float:
        mean = (places - specimen.mesh.nodes)[end > 0.0].mean(axis=0)
        return 0.02 * float(np.exp(-0.5) * (mean @ np.array([0.0, 0.6, -0.8])))

    one, other = (work(specimen.mesh.nodes + way * step * move) for way in (1.0, -1.0))
    assert float((pulled * move).sum()) == pytest.approx((one - other) / (2.0 * step), rel=1e-4)
    assert not pulled[end == 0.0].any()


@pytest.mark.parametrize('step', [1e-3, 1e-4, 1e-5])
def test_a_magnets_pull_falls_by_its_own_share(end: np.ndarray, step: float) -> None:
    changing = with_remanence(None, end, PULL)
    assert changing is not None
    for time in (0.001, 0.07, 0.3):
        slope = (changing(time + step) - changing(time - step)) / (2.0 * step)
        np.testing.assert_allclose(slope, -changing(time) / 0.1, rtol=1e-4)
    assert np.linalg.norm(changing(0.0).sum(axis=0)) == pytest.approx(0.02)


def test_a_magnet_draws_beside_what_else_acts(end: np.ndarray) -> None:
    def other(time: float) -> np.ndarray:
        return np.full((len(end), 3), time)

    assert with_remanence(other, end, Faults()) is other
    assert with_remanence(None, end, Faults()) is None
    both, alone = with_remanence(other, end, PULL), with_remanence(None, end, PULL)
    assert both is not None
    assert alone is not None
    np.testing.assert_allclose(both(0.05) - alone(0.05), 0.05)


def test_a_magnet_moves_a_body_its_way_and_not_before_the_release(
    setup: Setup, specimen: Specimen
) -> None:
    timing, times = draw_swing(np.random.default_rng(2)), [-0.1, 0.01, 0.03]
    drawn, quiet = (
        positions_at(specimen, setup, setup.observations[0], each, timing, times)
        for each in (PULL, Faults())
    )
    moved = np.array(drawn) - np.array(quiet)
    assert not moved[0].any()
    tip = specimen.shares > 0.99
    along = (moved[:, tip] @ np.array(PULL.remanent_way)).mean(axis=1)
    assert along[1] > 1e-5
    assert along[2] > 2.0 * along[1]
    # Both of its parts are there: a bar of about even sides goes the way that it is drawn.
    assert moved[2, tip, 1].mean() > 0.3 * along[2]
    assert moved[2, tip, 2].mean() < -0.4 * along[2]


@pytest.mark.parametrize(('family', 'most'), [('beam', (0.6, 1.0)), ('fin', (0.2, 0.35))])
def test_a_magnet_draws_across_what_is_flat(family: str, most: tuple[float, float]) -> None:
    drawn = draw_setup(family, is_sealed=True, poses=1, random=np.random.default_rng(5))
    aside, lasts = [], []
    for seed in range(10):
        effect = SWINGS_FOUR_OUTSIDE['remanent'](2, drawn, np.random.default_rng(seed))
        faults = Faults(**effect.changes)
        assert np.linalg.norm(faults.remanent_way) == pytest.approx(1.0, abs=1e-5)
        aside.append(abs(faults.remanent_way[1]))
        lasts.append(faults.remanent_time)
    assert most[0] < max(aside) < most[1]
    assert 0.05 < min(lasts) < max(lasts) < 0.2


def test_tears_lie_on_the_upper_side_amid_their_place() -> None:
    share = np.array([0.15, 0.15, 0.15, 0.15 + WIDE, 0.15 - WIDE, 0.6])
    height = np.array([1.0, 0.5, -0.7, 1.0, 1.0, 1.0])
    found = torn_share(share, height, 0.15)
    np.testing.assert_allclose(found[:5], [1.0, 0.5, 0.0, np.exp(-1.0), np.exp(-1.0)])
    assert found[5] < 1e-12


@pytest.mark.parametrize('law', ['stable', 'plain', 'mooney', 'fibres'])
def test_a_torn_bodys_energy_is_less_by_the_factor_of_its_places(setup: Setup, law: str) -> None:
    """Gauss point by Gauss point, whatever its law: of a strain that is the same all over."""
    own = replace(setup.rubber, law=law, share=0.2, direction=(0.6, 0.0, 0.8))
    whole = make_specimen(replace(setup, rubber=own), Faults(), refinement=0.3)
    F = np.array([[1.06, 0.02, 0.01], [0.0, 0.98, 0.03], [0.02, 0.0, 0.97]])
    places, body = whole.mesh.nodes @ F.T, torn(whole, TEARS)
    # The energy is so much by volume wherever a body is as stiff.
    density = whole.body.evaluate(places).energy / whole.body.quadrature.volumes.sum()
    at_points = whole.mesh.lattice[whole.body.cells].swapaxes(1, 2)
    x, _, z = (at_points @ whole.body.quadrature.values.T).swapaxes(0, 1)
    free = setup.shape.length - setup.shape.clamp
    share, height = np.maximum(x - setup.shape.clamp, 0.0) / free, 2.0 * z / setup.shape.section[1]
    less = np.exp(-1.4 * np.exp(-(((share - 0.15) / WIDE) ** 2)) * np.maximum(height, 0.0))
    expected = density * float((less * whole.body.quadrature.volumes).sum())
    assert body.evaluate(places).energy == pytest.approx(expected, rel=2e-3)
    assert expected < 0.97 * density * whole.body.quadrature.volumes.sum()
    assert np.array_equal(body.masses, whole.body.masses)


@pytest.mark.parametrize('step', STEPS)
def test_a_torn_bodys_forces_are_the_slope_of_its_energy(specimen: Specimen, step: float) -> None:
    body, random = torn(specimen, TEARS), np.random.default_rng(4)
    move = 1e-3 * random.standard_normal(specimen.mesh.nodes.shape)
    places = specimen.mesh.nodes * np.array([1.04, 0.99, 0.97]) + 0.05 * move
    slope = float((body.evaluate(places).gradient * move).sum())
    one, two = (body.evaluate(places + way * 1e2 * step * move).energy for way in (1.0, -1.0))
    assert (one - two) / (2e2 * step) == pytest.approx(slope, rel=1e-3)


def test_a_torn_body_rests_lower(setup: Setup, specimen: Specimen) -> None:
    up = setup.observations[0].world_from_object[1, :3]
    load = Load(-GRAVITY * specimen.body.masses[:, None] * up)
    whole, less = (
        find_equilibrium(body, load, specimen.mesh.nodes)
        for body in (specimen.body, torn(specimen, TEARS))
    )
    assert ((whole - less)[specimen.shares > 0.99] @ up).min() > 5e-4


def test_a_body_tears_once_on_its_way_and_loses_what_was_strained_there(
    setup: Setup, specimen: Specimen
) -> None:
    """Before and after it a swing keeps its energy; the same place and speed go over to it."""
    weight = specimen.body.masses[:, None] * np.array([0.0, 0.0, -GRAVITY])
    own = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    forces = Forces(weight, 0.0, make_drag(specimen.mesh, 0.0), setup.youngs_modulus)
    bodies = (specimen.body, torn(specimen, TEARS))
    step, start = 1e-3, specimen.mesh.nodes
    times = step * np.arange(1, 61)
    path = swing(bodies[0], own, forces, start, times, step, (0.03, bodies[1]))
    place, speed, whole = start, np.zeros_like(start), []
    for number, then in enumerate(path):
        # The trapezoidal rule's own speeds.
        place, speed = then, 2.0 / step * (then - place) - speed
        local = speed[specimen.body.cells]
        moving = 0.5 * float(np.einsum('cai,cab,cbi', local, own, local))
        still = bodies[number >= 30].evaluate(place, with_stiffness=False).energy
        whole.append(moving + still - float((weight * place).sum()))
    there = path[29]
    lost = bodies[0].evaluate(there).energy - bodies[1].evaluate(there).energy
    assert lost > 1e-6
    assert np.ptp(whole[:30]) < 0.05 * lost
    assert np.ptp(whole[30:]) < 0.05 * lost
    assert np.mean(whole[:30]) - np.mean(whole[30:]) == pytest.approx(lost, rel=0.05)


def test_a_body_is_filmed_as_it_was_until_it_tears(setup: Setup, specimen: Specimen) -> None:
    timing, times = draw_swing(np.random.default_rng(2)), [-0.1, 0.02, 0.0299, 0.07]
    tears, quiet = (
        np.array(positions_at(specimen, setup, setup.observations[0], each, timing, times))
        for each in (TEARS, Faults())
    )
    assert np.array_equal(tears[:3], quiet[:3])
    up = setup.observations[0].world_from_object[1, :3]
    assert ((quiet - tears)[3, specimen.shares > 0.99] @ up).min() > 2e-4


def test_tears_come_in_the_first_swing_down() -> None:
    for seed in range(10):
        drawn = draw_setup('waist', is_sealed=True, poses=1, random=np.random.default_rng(seed))
        effect = SWINGS_FOUR_OUTSIDE['tearing'](2, drawn, np.random.default_rng(seed))
        faults = Faults(**effect.changes)
        assert 0.05 < faults.tearing_time < 0.2
        assert faults.tearing > 0.0


@pytest.mark.slow
@pytest.mark.parametrize('name', list(SWINGS_FOUR_OUTSIDE))
def test_their_sizes_are_seen(name: str) -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    timing = draw_swing(np.random.default_rng(2))
    moves = moves_by_size(drawn, SWINGS_FOUR_OUTSIDE[name], timing, 0.6)
    assert 2.0 < moves[0] < 7.0
    assert 1.5 < moves[1] / moves[0] < 3.0
