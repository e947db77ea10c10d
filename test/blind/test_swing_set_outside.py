# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library of the set `swings` do what their labels say."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from support.blind_swings import moves_by_size, soft_beam

from benchmarks.blind.drag import make_drag
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import positions_at
from benchmarks.blind.laying import softer
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.rig_motion import acting, pulse, rig_acceleration, rig_at, rig_shift
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.shutter import filmed_views
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.stamping import moments
from benchmarks.blind.swing import consistent_masses, Forces, swing
from benchmarks.blind.swing_set_outside import SOFTER, SWING_SET_OUTSIDE
from benchmarks.blind.timing import draw_swing, Timing


@pytest.fixture(scope='module')
def setup() -> Setup:
    return soft_beam()


@pytest.fixture(scope='module')
def specimen(setup: Setup) -> Specimen:
    return make_specimen(setup, Faults(), refinement=0.5)


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    usual = replace(setup, youngs_modulus=setup.youngs_modulus / SOFTER)
    return Faults(**SWING_SET_OUTSIDE[name](size, usual, np.random.default_rng(8)).changes)


def _timing() -> Timing:
    return replace(draw_swing(np.random.default_rng(2)), frame_count=14)


def test_a_rigs_acceleration_is_that_of_its_shift(setup: Setup) -> None:
    faults = _drawn('shaken', setup)
    assert np.linalg.norm(faults.shaken_way) == pytest.approx(1.0, abs=1e-5)
    for time in (-0.1, 0.0, 0.07, 0.21):
        for step in (1e-3, 5e-4):
            one, two, three = (rig_shift(faults, time + k * step) for k in (-1, 0, 1))
            found = (one - 2.0 * two + three) / step**2
            np.testing.assert_allclose(found, rig_acceleration(faults, time), atol=2e-3 * 20.0)
    period = 1.0 / faults.shaken_rate
    way = np.array([rig_shift(faults, t) for t in np.linspace(0.0, period, 201)])
    assert np.linalg.norm(way, axis=1).max() == pytest.approx(1e-3 * faults.shaken, rel=1e-3)
    np.testing.assert_allclose(way[0], way[-1], atol=1e-12)


def test_a_soft_body_stays_where_it_is_while_its_rig_shakes_fast(
    setup: Setup, specimen: Specimen
) -> None:
    """Seen from the room: inertia draws it as far back as the rig has gone, but near the clamp."""
    fast = Faults(
        shaken=0.5, shaken_rate=150.0, shaken_phase=0.5 * np.pi, shaken_way=(0.0, 0.6, 0.8)
    )
    limp = make_specimen(replace(setup, youngs_modulus=2.0e3), Faults(), refinement=0.5)
    observation, masses = setup.observations[0], limp.body.masses
    own = consistent_masses(limp.mesh.nodes, limp.body, setup.density)
    changing = acting(observation, fast, masses, 0.0 * masses)
    weight = 1e-3 * masses[:, None] * np.array([0.0, 0.0, -9.81])
    forces = Forces(weight, 0.0, make_drag(limp.mesh, 0.0), 2.0e3, changing)
    when = 0.5 / fast.shaken_rate
    place = swing(limp.body, own, forces, limp.mesh.nodes, [when], when / 40.0)[0]
    outer = limp.shares > 0.6
    room = applied(rig_at(observation, fast, when).world_from_object, place)[outer]
    begun = applied(rig_at(observation, fast, 0.0).world_from_object, limp.mesh.nodes)[outer]
    rigid = rig_shift(fast, when) - rig_shift(fast, 0.0)
    assert np.linalg.norm(rigid) == pytest.approx(1e-3, rel=1e-6)
    assert np.abs(room - begun).max() < 0.05 * np.linalg.norm(rigid)


def test_the_block_around_the_clamp_shakes_too(setup: Setup, specimen: Specimen) -> None:
    faults = replace(_drawn('shaken', setup), shaken_way=(0.0, 0.0, 1.0))
    observation, timing = setup.observations[0], _timing()
    views = filmed_views(specimen, setup, observation, faults, timing)
    quiet = filmed_views(specimen, setup, observation, Faults(), timing)
    # A camera looks along -z of the world, nearly.
    ahead = (setup.depth_from_world[:3, :3] @ np.array([0.0, 0.0, 1.0]))[2]
    for number, when in enumerate(moments(timing, faults)):
        near, usual = (
            np.median(view.depth[(view.labels == FIXTURE) & np.isfinite(view.depth)])
            for view in (views[number], quiet[number])
        )
        moved = ahead * rig_shift(faults, when)[2]
        assert near - usual == pytest.approx(moved, abs=1.5e-4)


def test_a_kick_is_an_impulse_on_the_end_face(setup: Setup, specimen: Specimen) -> None:
    assert quad(pulse, -0.01, 0.02, points=[0.0, 0.008])[0] == pytest.approx(1.0)
    faults = _drawn('kicked', setup)
    assert np.linalg.norm(faults.kicked_way) == pytest.approx(1.0, abs=1e-5)
    masses = specimen.body.masses
    end = (specimen.shares > 1.0 - 1e-9) / np.count_nonzero(specimen.shares > 1.0 - 1e-9)
    changing = acting(setup.observations[0], faults, masses, end)
    assert changing is not None
    times = np.linspace(0.0, 0.008, 401)
    given = np.array([changing(time) for time in times])
    total = np.trapezoid(given, times, axis=0)
    np.testing.assert_allclose(
        total.sum(axis=0), faults.kicked * np.array(faults.kicked_way), rtol=1e-4, atol=1e-12
    )
    assert not total[end == 0.0].any()
    assert not changing(0.009).any()


@pytest.mark.slow
@pytest.mark.parametrize('name', list(SWING_SET_OUTSIDE))
def test_motions_converge_with_the_square_of_the_step(
    setup: Setup, specimen: Specimen, name: str
) -> None:
    faults, observation = _drawn(name, setup), setup.observations[0]
    masses = specimen.body.masses
    own = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    end = (specimen.shares > 1.0 - 1e-9) / np.count_nonzero(specimen.shares > 1.0 - 1e-9)
    forces = Forces(
        masses[:, None] * np.array([0.0, 0.0, -9.81]),
        20.0,
        make_drag(specimen.mesh, 0.0),
        6.0e5,
        acting(observation, faults, masses, end),
    )
    found = [
        swing(specimen.body, own, forces, specimen.mesh.nodes, [0.04], 0.04 / count)[0]
        for count in (80, 160, 320)
    ]
    coarse, fine = (np.linalg.norm(one - two) for one, two in pairwise(found))
    assert coarse / fine > 3.0
    assert np.abs(found[1] - found[2]).max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize('name', list(SWING_SET_OUTSIDE))
def test_their_sizes_are_seen_and_only_in_a_motion(name: str) -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    soft, timing, drawer = softer(drawn, SOFTER), _timing(), SWING_SET_OUTSIDE[name]
    specimen, observation = make_specimen(soft, Faults()), soft.observations[0]
    for size in (1, 2):
        faults = Faults(**drawer(size, drawn, np.random.default_rng(8)).changes)
        lying, other = (
            positions_at(specimen, soft, observation, each, timing, [-0.1])[0]
            for each in (faults, Faults())
        )
        assert np.array_equal(lying, other)
    moves = moves_by_size(drawn, drawer, timing)
    assert 1.0 < moves[0] < 7.0
    assert 1.4 < moves[1] / moves[0] < 3.0
