# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the ninth set has do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_rests import COARSE, rest_of, tip_moves

from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.material import constants, respond
from benchmarks.blind.ninth_outside import NINTH_OUTSIDE
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.simulation import make_specimen, Specimen

Depths = Callable[[Faults, int], np.ndarray]


@pytest.mark.parametrize('name', ['bath', 'trimmed', 'fabric'])
def test_a_cause_outside_moves_the_tip(setup: Setup, plain: Specimen, name: str) -> None:
    faults = Faults(**NINTH_OUTSIDE[name](2, setup, np.random.default_rng(8)).changes)
    lattice = make_specimen(setup, faults, COARSE).mesh.lattice[:, 0]
    at_tip = lattice > lattice.max() - 1e-9
    moves = tip_moves(setup, plain, faults, at_tip)
    assert 0.002 < max(moves) < 0.03


def test_a_bath_bears_all_that_is_deep_in_it_and_nothing_above(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    deep, dry = (rest_of(setup, Faults(bath=0.4, bath_level=level)) for level in (1.0, -1.0))
    lighter = rest_of(replace(setup, density=0.6 * setup.density), Faults())
    free = plain.shares > 0.0
    assert np.abs(deep - lighter)[free].max() < 1e-7
    assert np.abs(dry - rests[0]).max() < 1e-9


def test_a_bath_bears_the_lower_part_of_a_body(setup: Setup, rests: list[np.ndarray]) -> None:
    world = setup.observations[2].world_from_object
    level = float((rests[2] @ world[1, :3] + world[1, 3]).mean())
    whole, part = (rest_of(setup, Faults(bath=0.6, bath_level=each), 2) for each in (1.0, level))
    moved = [float(np.abs(each - rests[2]).max()) for each in (whole, part)]
    assert 0.01 * moved[0] < moved[1] < 0.99 * moved[0]


@pytest.mark.parametrize('family', ['beam', 'taper', 'tee'])
def test_a_trimmed_body_ends_sooner_and_is_else_the_same(family: str) -> None:
    world = draw_setup(family, is_sealed=False, poses=1, random=np.random.default_rng(4))
    short, whole = (make_specimen(world, each, 1.0) for each in (Faults(trimmed=7.0), Faults()))
    length = world.shape.length
    assert short.mesh.lattice[:, 0].max() == pytest.approx(length - 0.007, rel=1e-12)
    # What is left lies where it lay: both meshes place the same lattice points alike.
    x, y, z = world.shape.breaks
    points = np.array([[0.5 * (x[1] + x[2]), 0.3 * y[-1], 0.7 * z[-1]], [x[2] - 0.008, 0.0, z[0]]])
    one, other = (
        replace(world.shape, breaks=((*x[:-1], end), y, z), trimmed=cut).place(points)
        for end, cut in ((x[-1], 0.0), (x[-1] - 0.007, 0.007))
    )
    assert np.allclose(one, other, rtol=0.0, atol=1e-12)
    away = whole.mesh.lattice[:, 0] > length - 0.007
    assert short.body.masses.sum() < whole.body.masses.sum()
    assert short.body.masses.sum() > whole.body.masses.sum() - 1.5 * whole.body.masses[away].sum()


def test_some_of_a_crossbar_is_left_when_it_is_trimmed() -> None:
    for seed in range(20):
        world = draw_setup('tee', is_sealed=True, poses=1, random=np.random.default_rng(seed))
        effect = NINTH_OUTSIDE['trimmed'](2, world, np.random.default_rng(seed))
        low, high = world.shape.breaks[0][-2:]
        assert 1e-3 * effect.changes['trimmed'] < 0.81 * (high - low)


def test_a_fabric_resists_a_pull_and_is_slack_under_a_push() -> None:
    fabric = Fibres(np.full((1, 1), 5e4), np.array([1.0, 0.0, 0.0]), slack=True)
    numbers = replace(constants(np.full((1, 1), 1e5), 0.3), fabric=fabric)
    plain = replace(numbers, fabric=None)
    shear = np.array([[0.0, 0.1, 0.02], [0.0, 0.0, 0.0], [0.05, 0.0, 0.0]])
    for stretch, stress in ((1.05, 4.0 * 5e4 * (1.05**2 + 0.05**2 - 1.0)), (0.9, 0.0)):
        F = (np.diag([stretch, 1.0, 1.0]) + shear)[None, None]
        more = respond(F, numbers).energy - respond(F, plain).energy
        assert more.item() == pytest.approx(stress**2 / (16.0 * 5e4), rel=1e-9)
        own = fabric.stress(F)[0, 0]
        assert own[:, 0] == pytest.approx(stress * F[0, 0, :, 0], rel=1e-9)
        assert np.abs(own[:, 1:]).max() == 0.0
    # What its stiffness says is the slope of its forces, on either side of where it is slack.
    random = np.random.default_rng(2)
    gradients, volumes = random.standard_normal((1, 1, 20, 3)), np.array([[1e-3]])
    for stretch in (1.05, 0.9):
        F = (np.diag([stretch, 1.0, 1.0]) + shear)[None, None]
        move = random.standard_normal((20, 3))
        change = 1e-6 * (move.T @ gradients[0, 0])
        ends = [fabric.stress(F + sign * change) for sign in (1.0, -1.0)]
        slope = volumes[0, 0] * gradients[0, 0] @ np.subtract(*ends)[0, 0].T / 2e-6
        found = np.einsum('aibj,bj->ai', fabric.blocks(F, gradients, volumes)[0], move)
        assert found == pytest.approx(slope, rel=1e-5, abs=1e-6)


def test_a_body_with_a_fabric_above_sags_less_unless_it_is_upside_down(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    tip = plain.shares > 0.99
    ratios = []
    for pose in (0, 3):
        up = setup.observations[pose].world_from_object[1, :3]
        sags = [
            float((where - plain.mesh.nodes)[tip].mean(axis=0) @ up)
            for where in (rest_of(setup, Faults(fabric=8.0), pose), rests[pose])
        ]
        ratios.append(sags[0] / sags[1])
    assert ratios[0] < 0.75
    assert ratios[1] > 0.9


def test_a_warm_body_with_a_fabric_rests_as_one_that_is_softer_all_over(setup: Setup) -> None:
    soft = replace(setup, youngs_modulus=setup.youngs_modulus * np.exp(-0.4))
    warm = rest_of(setup, Faults(warming=0.4, fabric=3.0), 3)
    assert np.abs(warm - rest_of(soft, Faults(fabric=3.0), 3)).max() < 1e-8


def test_a_mirror_that_wobbles_shifts_rows_and_leaves_depths(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    views = [
        true_rendering(plain, setup, setup.observations[2], faults, rests[2])
        for faults in (
            Faults(),
            Faults(wobble=12.0, wobble_period=160.0, wobble_phase=0.7),
        )
    ]
    middles = []
    for view in views:
        seen = np.isfinite(view.depth[..., 4])
        rows = view.row + np.flatnonzero(seen.sum(axis=1) > 20)
        columns = view.column + np.arange(seen.shape[1])
        found = {row: float(columns[seen[row - view.row]].mean()) for row in rows}
        middles.append(found)
    common = sorted(set(middles[0]) & set(middles[1]))
    shift = np.array([middles[1][row] - middles[0][row] for row in common])
    expected = 12.0 * np.sin(2.0 * np.pi * np.array(common) / 160.0 + 0.7)
    assert len(common) > 60
    assert np.abs(shift - expected).max() < 1.5
    assert np.ptp(expected) > 12.0
    ends = [(np.nanmin(v.depth), np.max(v.depth[np.isfinite(v.depth)])) for v in views]
    assert ends[0] == pytest.approx(ends[1], abs=1e-3)


def test_causes_of_the_sensor_leave_the_body_where_it_is(setup: Setup, depths: Depths) -> None:
    faults = Faults(**NINTH_OUTSIDE['wobble'](2, setup, np.random.default_rng(8)).changes)
    assert np.array_equal(rest_of(setup, faults), rest_of(setup, Faults()))
    assert not np.array_equal(depths(faults, 0), depths(Faults(), 0))
