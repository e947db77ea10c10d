# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twentieth set has do what their labels say."""

from collections.abc import Callable

import numpy as np
import pytest
from support.blind_rests import rest_of, tip_moves

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Setup
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentieth_outside import TWENTIETH_OUTSIDE
from benchmarks.blind.updraught import updraught_push

Depths = Callable[[Faults, int], np.ndarray]


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTIETH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_air_is_pushed_up_most_on_an_axis_and_alike_at_all_heights() -> None:
    faults = Faults(updraught=4.0, updraught_at=(0.02, -0.01), updraught_width=0.05)
    places = np.array([[0.02, 0.0, -0.01], [0.02, 0.4, 0.04], [0.05, -0.2, 0.03], [2.0, 0.0, 0.0]])
    expected = 4.0 * np.exp([0.0, -1.0, -1.0, -np.inf])
    assert updraught_push(places, faults) == pytest.approx(expected, abs=1e-12)


def test_an_updraught_moves_a_tip_up_by_some_4_and_10_mm(setup: Setup, plain: Specimen) -> None:
    tip = plain.shares > 0.99
    for size, least, most in ((1, 2.5, 6.0), (2, 7.0, 15.0)):
        faults = _drawn('updraught', setup, size)
        assert least < 1e3 * max(tip_moves(setup, plain, faults, tip)) < most
        for pose in (0, 1):
            up = setup.observations[pose].world_from_object[1, :3]
            away = (rest_of(setup, faults, pose) - rest_of(setup, Faults(), pose))[tip] @ up
            assert away.mean() > 1e-3


@pytest.mark.parametrize(('worth', 'is_set'), [(4.0, 1), (-4.0, 0), (10.5, 1), (-10.5, 0)])
def test_a_bit_that_is_stuck_is_the_same_in_all_depths(
    setup: Setup, depths: Depths, worth: float, is_set: int
) -> None:
    for pose in (0, 3):
        right, view = depths(Faults(), pose), depths(Faults(stuck=worth), pose)
        there = np.isfinite(right)
        assert np.array_equal(there, np.isfinite(view))
        # All else of a depth is left: what it is beyond that bit, and in units of two of it.
        step = 1e-3 * abs(worth)
        whole, rest = np.divmod(right[there], 2.0 * step)
        expected = 2.0 * step * whole + rest % step + is_set * step
        assert view[there] == pytest.approx(expected, abs=1e-12)
        assert 0.1 < np.mean(view[there] != right[there]) < 0.95


def test_a_bit_that_is_stuck_counts_for_some_4_and_10_mm(setup: Setup) -> None:
    for size, most in ((1, 4.2), (2, 10.5)):
        assert abs(_drawn('stuck', setup, size).stuck) == pytest.approx(most, rel=0.16)
