# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the eighteenth set has do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_rests import COARSE, rest_of, tip_moves

from benchmarks.blind.bleeding import bleeding_share
from benchmarks.blind.eighteenth_outside import EIGHTEENTH_OUTSIDE
from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen

Depths = Callable[[Faults, int], np.ndarray]


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**EIGHTEENTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_a_gel_shrinks_by_the_root_of_the_time(setup: Setup) -> None:
    faults = _drawn('shrinking', setup)
    assert faults.shrinking_shares == pytest.approx(np.sqrt(np.arange(4) / 3.0), abs=1e-4)
    free = setup.shape.length - setup.shape.clamp
    assert 0.01 * faults.shrinking * free == pytest.approx(0.01, rel=0.16)


def test_a_gel_that_is_not_loaded_shrinks_alike_on_all_sides(setup: Setup) -> None:
    # So stiff that its weight does not matter; only the clamp keeps what it holds.
    stiff = replace(setup, youngs_modulus=1e4 * setup.youngs_modulus)
    faults = replace(_drawn('shrinking', stiff), shrinking=8.0)
    body = make_specimen(stiff, faults, COARSE)
    nodes, free = body.mesh.nodes, body.shares > 0.4
    for pose, share in enumerate(faults.shrinking_shares):
        rest = settle(body, stiff, stiff.observations[pose], faults)
        left = 1.0 - 0.08 * share
        whole, found = nodes[free] - nodes[free].mean(axis=0), rest[free] - rest[free].mean(axis=0)
        assert found == pytest.approx(left * whole, abs=5e-5)
        assert rest[body.body.held] == pytest.approx(nodes[body.body.held], abs=1e-12)


def test_a_gel_loses_the_weight_of_what_it_loses_in_volume(setup: Setup) -> None:
    faults = Faults(shrinking=10.0, shrinking_shares=(0.5, 1.0, 1.0, 1.0))
    tip = make_specimen(setup, faults, COARSE).shares > 0.99
    sag, whole = (float(rest_of(setup, each)[tip, 2].mean()) for each in (faults, Faults()))
    # Bernoulli's beam by its own weight: by its size squared, at the same modulus and density.
    assert sag / whole == pytest.approx(0.95**2, rel=0.02)


def test_a_gel_moves_its_tip_by_some_4_and_10_mm(setup: Setup, plain: Specimen) -> None:
    for size, least, most in ((1, 2.5, 6.0), (2, 7.0, 15.0)):
        moves = tip_moves(setup, plain, _drawn('shrinking', setup, size), plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most
        assert moves[0] == 0.0
        assert moves == sorted(moves)


def _view(depth: np.ndarray) -> Rendering:
    labels = np.where(np.isfinite(depth), 1, -1)
    return Rendering(20, 10, depth, labels, np.ones(depth.shape))


def test_an_outline_bleeds_by_the_exponential_of_the_way_inwards() -> None:
    depth = np.full((12, 15, 9), np.inf)
    depth[2:10, 3:13] = 0.3
    found = bleeding_share(_view(depth), 2.5)
    assert (found[~np.isfinite(depth)] == 1.0).all()
    # A box's samples: how far each is from the first that sees nothing, up or down or aside.
    offsets = (np.arange(3) - 1.0) / 3.0
    rows = np.arange(12)[:, None, None] + np.repeat(offsets, 3)
    columns = np.arange(15)[None, :, None] + np.tile(offsets, 3)
    first = 2.0 / 3.0
    away = np.minimum(
        np.minimum(rows - (2.0 - first), 9.0 + first - rows),
        np.minimum(columns - (3.0 - first), 12.0 + first - columns),
    )
    inside = np.isfinite(depth)
    assert found[inside] == pytest.approx(np.exp(-away[inside] / 2.5))


def test_depths_are_longer_towards_the_outline(setup: Setup, depths: Depths) -> None:
    for size, most in ((1, 0.0042), (2, 0.0105)):
        faults = _drawn('bleeding', setup, size)
        assert 1e-3 * faults.bleeding == pytest.approx(most, rel=0.16)
        for pose in (0, 3):
            right, view = depths(Faults(), pose), depths(faults, pose)
            there = np.isfinite(right)
            assert np.array_equal(there, np.isfinite(view))
            error = view[there] - right[there]
            assert error.min() >= 0.0
            # A sample on the outline is a third of a pixel from the next that sees nothing.
            top = 1e-3 * faults.bleeding * np.exp(-1.0 / 3.0 / faults.bleeding_width)
            assert error.max() == pytest.approx(top, abs=1e-9)
            assert np.median(error) < 0.6 * top
