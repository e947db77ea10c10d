# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library of the set `swings_two` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_draws import STEPS
from support.blind_swings import (
    check_draws_by_its_energy,
    energies_of_a_swing,
    moves_by_size,
    soft_beam,
)

from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import drawing, leash, positions_at
from benchmarks.blind.laying import softer
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.shutter import by_range_rate, filmed_views
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.stamping import moments
from benchmarks.blind.swing_set_outside import SOFTER
from benchmarks.blind.swings_two_outside import SWINGS_TWO_OUTSIDE
from benchmarks.blind.timing import draw_swing


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


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    usual = replace(setup, youngs_modulus=setup.youngs_modulus / SOFTER)
    return Faults(**SWINGS_TWO_OUTSIDE[name](size, usual, np.random.default_rng(8)).changes)


@pytest.mark.parametrize('step', STEPS)
def test_a_leash_draws_by_its_energy(
    setup: Setup, specimen: Specimen, rest: np.ndarray, step: float
) -> None:
    law = leash(specimen, rest, _drawn('leash', setup))
    # As far below its rest as that is below where it was let go.
    check_draws_by_its_energy(law, 2.0 * rest - specimen.mesh.nodes, step)


def test_a_leash_hangs_loose_until_a_body_is_far_below_its_rest(
    setup: Setup, specimen: Specimen, rest: np.ndarray
) -> None:
    faults = _drawn('leash', setup)
    law, nodes = leash(specimen, rest, faults), specimen.mesh.nodes
    for part in (0.0, 0.5, 1.0, 1.1):
        assert law(nodes + part * (rest - nodes)).energy == 0.0
    # Each node's part pulls towards the post, by how much farther than loose that is.
    post = 1e-3 * np.array(faults.leash_post)
    below = 2.0 * rest - nodes
    pull = -law(below).gradient
    felt = np.linalg.norm(pull, axis=1)
    assert felt @ specimen.shares / felt.sum() == pytest.approx(faults.leash_at, abs=0.04)
    way = (post - below)[felt > 0.0]
    np.testing.assert_allclose(np.cross(way, pull[felt > 0.0]), 0.0, atol=1e-12)
    far, near, most = (np.linalg.norm(each - post, axis=1) for each in (below, nodes, rest))
    loose = near + faults.leash_taut * (most - near)
    parts = felt[felt > 0.0] / (far - loose)[felt > 0.0]
    assert (parts > 0.0).all()
    assert parts.sum() == pytest.approx(faults.leash, rel=1e-9)
    # The post is straight above it in the world.
    up = setup.observations[0].world_from_object[:3, :3] @ (post - felt @ nodes / felt.sum())
    assert up[1] == pytest.approx(0.15, abs=0.002)
    assert np.abs(up[[0, 2]]).max() < 0.002


def test_a_swing_in_a_leash_keeps_its_energy(
    setup: Setup, specimen: Specimen, weight: np.ndarray
) -> None:
    faults = replace(_drawn('leash', setup), leash_taut=0.2)
    laws = drawing(specimen, weight, faults)
    whole, drawn = energies_of_a_swing(specimen, setup, weight, laws, 0.06)
    assert len(laws) == 1
    assert drawn[0] == 0.0
    assert drawn.max() > 1e-6
    assert np.ptp(whole) < 0.1 * drawn.max()


@pytest.mark.parametrize('amount', [30.0, -30.0])
def test_a_range_errs_by_its_rate_along_the_ray(
    setup: Setup, specimen: Specimen, amount: float
) -> None:
    view, nodes = setup.observations[0], specimen.mesh.nodes
    to_camera = setup.depth_from_world @ view.world_from_object
    speed = np.array([0.1, -0.2, 0.5])
    places = np.array([nodes + time * speed for time in (-1e-3, 0.0, 1e-3)])
    seeming = by_range_rate(places, setup, view, Faults(doppler=amount))
    then, found = applied(to_camera, nodes), applied(to_camera, seeming)
    # It is seen at the same pixel.
    np.testing.assert_allclose(setup.camera.project(found), setup.camera.project(then), atol=1e-6)
    rays = then / np.linalg.norm(then, axis=1)[:, None]
    rates = rays @ (to_camera[:3, :3] @ speed)
    errors = np.linalg.norm(found, axis=1) - np.linalg.norm(then, axis=1)
    np.testing.assert_allclose(errors, 1e-3 * amount * rates, atol=1e-7)
    assert np.abs(errors).max() > 1e-3


@pytest.mark.parametrize('step', STEPS)
def test_a_rate_of_a_range_is_its_slope(setup: Setup, specimen: Specimen, step: float) -> None:
    """A body that turns: its nodes go by speeds of their own."""
    view, nodes = setup.observations[0], specimen.mesh.nodes
    to_camera = setup.depth_from_world @ view.world_from_object
    speeds = np.cross([0.0, 3.0, 1.0], nodes)
    places = np.array([nodes + time * speeds for time in (-1e-3, 0.0, 1e-3)])
    seeming = by_range_rate(places, setup, view, Faults(doppler=1e3))
    found = np.linalg.norm(applied(to_camera, seeming), axis=1)
    now, one, other = (
        np.linalg.norm(applied(to_camera, nodes + way * step * speeds), axis=1)
        for way in (0.0, 1.0, -1.0)
    )
    np.testing.assert_allclose(found - now, (one - other) / (2.0 * step), rtol=1e-4, atol=1e-6)


def test_a_body_that_lies_on_its_ledge_is_seen_where_it_is(
    setup: Setup, specimen: Specimen
) -> None:
    timing = replace(draw_swing(np.random.default_rng(2)), release=0.02, frame_count=2)
    view = setup.observations[0]
    errs, quiet = (
        filmed_views(specimen, setup, view, each, timing)
        for each in (Faults(doppler=20.0), Faults())
    )
    for number, when in enumerate(moments(timing, Faults())):
        one, two = errs[number], quiet[number]
        assert (one.row, one.column, one.depth.shape) == (two.row, two.column, two.depth.shape)
        both = np.isfinite(one.depth) & np.isfinite(two.depth)
        off = float(np.abs(one.depth[both] - two.depth[both]).max())
        assert (off > 1e-4) == (when > 0.0)


@pytest.mark.slow
def test_sizes_of_a_leash_are_seen_and_only_in_a_motion() -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    soft, timing = softer(drawn, SOFTER), draw_swing(np.random.default_rng(2))
    drawer, specimen = SWINGS_TWO_OUTSIDE['leash'], make_specimen(soft, Faults(), 0.5)
    faults = Faults(**drawer(2, drawn, np.random.default_rng(8)).changes)
    lying, other = (
        positions_at(specimen, soft, soft.observations[0], each, timing, [-0.1])[0]
        for each in (faults, Faults())
    )
    assert np.array_equal(lying, other)
    moves = moves_by_size(drawn, drawer, timing)
    assert 1.0 < moves[0] < 7.0
    assert 1.4 < moves[1] / moves[0] < 3.0
