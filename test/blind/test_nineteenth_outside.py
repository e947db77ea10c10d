# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the nineteenth set has do what their labels say."""

from collections.abc import Callable

import numpy as np
import pytest
from support.blind_rests import COARSE, tip_moves

from benchmarks.blind.faults import Faults
from benchmarks.blind.moduli import PARTED
from benchmarks.blind.nineteenth_outside import NINETEENTH_OUTSIDE
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.trailing import trailing_share

Depths = Callable[[Faults, int], np.ndarray]


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**NINETEENTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_two_halves_are_apart_amid_the_height_from_a_place_on(setup: Setup) -> None:
    parted = make_specimen(setup, Faults(unglued=0.6), COARSE)
    softness = np.asarray(parted.body.numbers.shear)
    softer = np.log(softness.max() / softness)
    places = parted.body.quadrature.values @ parted.mesh.nodes[parted.mesh.cells]
    free = setup.shape.length - setup.shape.clamp
    outer = places[..., 0] > setup.shape.clamp + 0.4 * free
    # A fifth of the height, in the middle of it.
    amid = np.abs(places[..., 2]) < 0.1 * setup.shape.section[1]
    assert amid.mean() == pytest.approx(0.2)
    assert softer == pytest.approx(PARTED * (amid & outer), abs=1e-9)
    whole = make_specimen(setup, Faults(), COARSE)
    assert parted.body.masses.sum() == pytest.approx(whole.body.masses.sum())


def test_two_halves_bend_more_where_they_slide_on_each_other(setup: Setup) -> None:
    more = []
    for pose, axis in ((0, 2), (1, 1)):
        sags = []
        for faults in (Faults(), Faults(unglued=0.9)):
            specimen = make_specimen(setup, faults, COARSE)
            rest = settle(specimen, setup, setup.observations[pose], faults)
            tip = specimen.shares > 0.99
            sags.append(abs(float((rest - specimen.mesh.nodes)[tip, axis].mean())))
        more.append(sags[1] / sags[0] - 1.0)
    assert more[0] > 0.3
    # Halves that bend in the plane between them lack a fifth of what bears, and do not slide.
    assert more[1] == pytest.approx(0.2, abs=0.12)


def test_halves_that_come_apart_move_a_tip_by_some_4_and_10_mm(
    setup: Setup, plain: Specimen
) -> None:
    for size, least, most in ((1, 2.5, 6.0), (2, 6.0, 16.0)):
        faults = _drawn('unglued', setup, size)
        tip = make_specimen(setup, faults, COARSE).shares > 0.99
        assert least < 1e3 * max(tip_moves(setup, plain, faults, tip)) < most


def test_a_beam_trails_by_the_exponential_of_the_way_down_a_column() -> None:
    random = np.random.default_rng(3)
    samples = random.random((36, 15)) < 0.8
    depth = np.where(samples, 0.3, np.inf).reshape(12, 3, 5, 3).swapaxes(1, 2).reshape(12, 5, 9)
    view = Rendering(20, 10, depth, np.where(np.isfinite(depth), 1, -1), np.ones(depth.shape))
    found = trailing_share(view, 2.5).reshape(12, 5, 3, 3).swapaxes(1, 2).reshape(36, 15)
    for column in range(15):
        since = 0
        expected = np.empty(36)
        for row in range(36):
            since = since + 1 if row and samples[row - 1, column] else 0
            expected[row] = np.exp(-since / 3.0 / 2.5)
        there = samples[:, column]
        assert found[there, column] == pytest.approx(expected[there])


def test_depths_err_most_at_the_upper_outline(setup: Setup, depths: Depths) -> None:
    for size, most in ((1, 0.0042), (2, 0.0105)):
        faults = _drawn('trailing', setup, size)
        assert 1e-3 * abs(faults.trailing) == pytest.approx(most, rel=0.16)
        for pose in (0, 3):
            right, view = depths(Faults(), pose), depths(faults, pose)
            there = np.isfinite(right)
            assert np.array_equal(there, np.isfinite(view))
            errors = np.where(there, view - np.where(there, right, 0.0), 0.0)
            share = errors / (1e-3 * faults.trailing)
            assert share[there].min() > 0.0
            assert share.max() == pytest.approx(1.0)
            # Down a column of whole bodies it only falls.
            column = there.all(axis=-1).sum(axis=0).argmax()
            inside = np.flatnonzero(there.all(axis=-1)[:, column])
            assert (np.diff(inside) == 1).all()
            assert (np.diff(share[inside, column].mean(axis=-1)) < 0.0).all()
