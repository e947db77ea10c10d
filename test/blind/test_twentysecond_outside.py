# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-second set has do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_derivatives import check_derivatives
from support.blind_rests import rest_of, tip_moves

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.pulls import pulls, reel
from benchmarks.blind.renderer import through_drop
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentysecond_outside import TWENTYSECOND_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYSECOND_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


@pytest.mark.parametrize('step', [1e-5, 1e-6, 1e-7])
def test_a_reel_pulls_by_its_energy(step: float) -> None:
    places = np.random.default_rng(1).uniform(-0.1, 0.1, (12, 3))
    law = reel(np.array([0.2, 0.3, -0.1]), np.linspace(0.1, 0.4, 12))
    check_derivatives(law, places, step=step)


def test_a_reel_pulls_the_tip_as_hard_wherever_that_is(setup: Setup, plain: Specimen) -> None:
    faults = _drawn('reeled', setup)
    for pose, shift in ((0, 0.0), (1, 0.05), (3, -0.08)):
        view = setup.observations[pose]
        (law,) = pulls(plain.body.masses, plain.shares, view, faults)
        nodes = plain.mesh.nodes + shift
        pull = -law(nodes).gradient
        tied = plain.shares > 0.97
        assert not pull[~tied].any()
        sizes = np.linalg.norm(pull[tied], axis=1)
        assert sizes.sum() == pytest.approx(faults.reeled)
        # Towards a place of the room.
        away = np.array(faults.pull_point) - applied(view.world_from_object, nodes)[tied]
        along = pull[tied] @ view.world_from_object[:3, :3].T
        expected = sizes[:, None] * away / np.linalg.norm(away, axis=1)[:, None]
        assert along == pytest.approx(expected, abs=1e-12)


def test_a_reel_moves_a_tip_by_some_4_and_10_mm(setup: Setup, plain: Specimen) -> None:
    tip = plain.shares > 0.99
    for size, least, most in ((1, 2.5, 6.0), (2, 6.5, 15.0)):
        faults = _drawn('reeled', setup, size)
        assert least < 1e3 * max(tip_moves(setup, plain, faults, tip)) < most
    point = np.array(faults.pull_point)
    for pose in range(4):
        world = setup.observations[pose].world_from_object
        before, after = (
            applied(world, rest_of(setup, each, pose))[tip].mean(axis=0)
            for each in (Faults(), faults)
        )
        assert np.linalg.norm(after - point) < np.linalg.norm(before - point) - 1e-3


@pytest.mark.parametrize('most', [17.5, -17.5, 7.0])
def test_a_drop_shifts_by_the_slope_of_its_bell(most: float) -> None:
    drop = (12.0, -20.0, most, 52.0)
    x, y = np.random.default_rng(1).uniform(-160.0, 160.0, (2, 400))

    def thick(across: np.ndarray, down: np.ndarray) -> np.ndarray:
        squares = (across - 12.0) ** 2 + (down + 20.0) ** 2
        return np.asarray(most * 52.0 * np.exp(0.5 - 0.5 * squares / 52.0**2))

    aside, below = through_drop(x, y, drop)
    for step in (1e-2, 1e-3, 1e-4):
        across = (thick(x - step, y) - thick(x + step, y)) / (2.0 * step)
        down = (thick(x, y - step) - thick(x, y + step)) / (2.0 * step)
        assert aside - x == pytest.approx(across, abs=2e-5)
        assert below - y == pytest.approx(down, abs=2e-5)
    # Most at its width from the middle, on all sides.
    angles = np.linspace(0.0, 2.0 * np.pi, 13)
    rim = np.array([12.0 + 52.0 * np.cos(angles), -20.0 + 52.0 * np.sin(angles)])
    moved = np.array(through_drop(*rim, drop)) - rim
    assert np.hypot(*moved) == pytest.approx(np.full(13, abs(most)))
    assert np.hypot(aside - x, below - y).max() <= abs(most) + 1e-9


def test_places_behind_a_drop_keep_their_order(setup: Setup) -> None:
    for seed in range(8):
        for family in ('beam', 'arch', 'waist', 'fin', 'tee'):
            drawn = draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(seed))
            changes = TWENTYSECOND_OUTSIDE['droplet'](
                2, drawn, np.random.default_rng(seed)
            ).changes
            faults = Faults(**changes)
            drop = (*faults.droplet_at, faults.droplet, faults.droplet_width)
            ways = drop[3] * np.linspace(0.0, 4.0, 400)
            seen, _ = through_drop(drop[0] + ways, np.full(400, drop[1]), drop)
            assert np.diff(seen).min() > 0.0
            # It is before the body, which is seen around the image's middle.
            assert np.hypot(*faults.droplet_at) < 130.0


def test_a_drop_shifts_what_a_sensor_sees_and_keeps_its_depth(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, camera = _drawn('droplet', setup), setup.camera
    drop = (*faults.droplet_at, faults.droplet, faults.droplet_width)
    pose = setup.observations[0]
    places = applied(setup.depth_from_world @ pose.world_from_object, rests[0])
    plainly, bent = (each.project(places) for each in (camera, replace(camera, drop=drop)))
    middle = np.array([camera.cx, camera.cy])
    expected = middle + np.stack(through_drop(*(plainly - middle).T, drop), axis=-1)
    assert bent == pytest.approx(expected, abs=1e-9)
    right, view = (
        true_rendering(plain, setup, pose, each, rests[0]) for each in (Faults(), faults)
    )
    depths = [each.depth[np.isfinite(each.depth)] for each in (right, view)]
    assert depths[1].min() == pytest.approx(depths[0].min(), abs=1e-3)
    assert depths[1].max() == pytest.approx(depths[0].max(), abs=1e-3)
    areas = [(np.isfinite(each.depth) & (each.labels != 2)).sum() for each in (right, view)]
    # A thick drop spreads what is behind it, and a hollow one draws it together.
    assert (areas[1] > areas[0]) == (faults.droplet > 0.0)


def test_a_drop_shifts_by_some_4_and_10_mm(setup: Setup) -> None:
    for size, most in ((1, 0.004), (2, 0.010)):
        distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
        way = abs(_drawn('droplet', setup, size).droplet) * distance / setup.camera.fx
        assert way == pytest.approx(most, rel=0.3)
