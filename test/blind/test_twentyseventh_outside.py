# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-seventh set has do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_draws import draw_sealed, SEALED
from support.blind_rests import rubber_volumes, tip_moves
from support.blind_views import spread_of_what_stays, with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.moire import moire_error
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import Setup
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentyseventh_outside import TWENTYSEVENTH_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYSEVENTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_a_joggled_mould_is_shifted_beyond_a_bend_like_an_s(setup: Setup) -> None:
    shape = setup.shape
    free, half = shape.length - shape.clamp, 0.5 * np.array(shape.section)
    joggled = true_shape(shape, Faults(joggled=5.0, joggled_at=0.4, joggled_way=150.0))
    ahead = shape.clamp + np.array([-0.1, 0.0, 0.29, 0.35, 0.4, 0.45, 0.51, 1.0]) * free
    places = np.column_stack([ahead, np.tile(half * [0.9, -0.5], (8, 1))])
    shift = 1e3 * (joggled.place(places) - shape.place(places))
    assert shift[:, 0] == pytest.approx(0.0, abs=1e-12)
    # To the side of negative y, and half as far up as all of it.
    assert shift[-1, 1:] == pytest.approx([-5.0 * np.sqrt(0.75), 2.5])
    far = np.linalg.norm(shift, axis=1) / 5.0
    assert far == pytest.approx([0.0, 0.0, 0.0, 5 / 32, 0.5, 27 / 32, 1.0, 1.0], abs=1e-12)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_joggled_body_has_as_much_rubber(family: str) -> None:
    drawn = draw_sealed(family)
    found, whole = rubber_volumes(drawn, _drawn('joggled', drawn))
    # An arch is bent after it was shifted across.
    assert found == pytest.approx(whole, rel=0.02)


def test_a_joggled_bodys_tip_is_some_4_and_10_mm_off(setup: Setup, plain: Specimen) -> None:
    tip = plain.shares > 0.99
    for size, most in ((1, 4.0), (2, 10.0)):
        moves = 1e3 * np.array(tip_moves(setup, plain, _drawn('joggled', setup, size), tip))
        assert moves == pytest.approx(most, rel=0.25)


def test_a_moire_beats_along_two_ways(setup: Setup) -> None:
    faults = Faults(
        moire=5.0, moire_periods=(60.0, 80.0), moire_slant=30.0, moire_phases=(0.4, -0.9)
    )
    column, row = round(setup.camera.cx) - 150, round(setup.camera.cy) - 150
    depth = np.full((300, 300, 9), 0.3)
    view = Rendering(column, row, depth, np.ones(depth.shape, dtype=np.int64), depth)
    found = np.asarray(moire_error(view, setup, faults))
    assert found.shape == (300, 300, 1)
    middle = np.array([setup.camera.cx, setup.camera.cy])
    way, other = np.array([np.sqrt(0.75), 0.5]), np.array([-0.5, np.sqrt(0.75)])
    for turns in ((0.0, 0.0), (1.3, 0.2), (-0.7, 1.1), (0.5, -1.4)):
        place = middle + 60.0 * turns[0] * way + 80.0 * turns[1] * other
        x, y = np.round(place - [column, row]).astype(int)
        angles = 2.0 * np.pi * np.array(turns) + [0.4, -0.9]
        # What a pixel's place is off by, times how fast it swings.
        off = 0.005 * 0.71 * 2.0 * np.pi / 60.0 * np.sqrt(2.0)
        assert found[y, x, 0] == pytest.approx(0.005 * np.cos(angles).prod(), abs=off)
    # The mean of its square is that of one wave's times the other's.
    assert (found**2).mean() == pytest.approx(0.25 * 0.005**2, rel=0.1)
    assert moire_error(view, setup, replace(faults, moire=0.0)) == 0.0


def test_a_moire_is_the_same_in_all_poses(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    for size, most in ((1, 7.2), (2, 17.0)):
        faults, found, told = _drawn('moire', setup, size), [], {}
        for pose in (0, 2):
            seen = with_and_without(plain, setup, faults, pose, rests[pose])
            found.append(spread_of_what_stays(seen, told))
        assert 0.7 * most < max(found) < 1.16 * most
