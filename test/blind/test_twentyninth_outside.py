# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-ninth set has do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_sealed, SEALED
from support.blind_rests import COARSE, rubber_volumes, tip_moves

from benchmarks.blind.faults import Faults
from benchmarks.blind.jittering import jittered
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.twentyninth_outside import TWENTYNINTH_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYNINTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_a_clubs_section_grows_towards_its_tip(setup: Setup) -> None:
    shape, half = setup.shape, 0.5 * np.array(setup.shape.section)
    club = true_shape(shape, Faults(clubbed=0.6))
    free = shape.length - shape.clamp
    across = half * np.array([[1, 1], [1, -1], [-1, 0.5], [0.3, 0], [0, 0]])
    for share, part in ((0.0, 0.0), (0.65, 0.0), (0.7375, 0.146447), (0.825, 0.5), (1.0, 1.0)):
        places = np.column_stack([np.full(5, shape.clamp + share * free), across])
        before, after = shape.place(places), club.place(places)
        assert after[:, 0] == pytest.approx(before[:, 0])
        assert after[:, 1:] == pytest.approx((1.0 + 0.6 * part) * before[:, 1:], abs=1e-8)


def test_a_clubbed_beam_has_more_rubber_at_its_tip(setup: Setup) -> None:
    more, whole = rubber_volumes(setup, Faults(clubbed=0.5))
    width, height = setup.shape.section
    # A bell of half a cosine's wave: its mean is 1/2 and that of its square 3/8.
    outer = 0.35 * (setup.shape.length - setup.shape.clamp) * width * height
    # Cells are few there.
    assert more - whole == pytest.approx((0.5 + 0.25 * 3.0 / 8.0) * outer, rel=0.02)


def _goes_out(drawn: Setup, faults: Faults) -> float:
    """Return how far a corner of the tip goes out at most [mm]."""
    nodes = make_specimen(drawn, Faults(), COARSE).mesh.lattice
    tip = nodes[nodes[:, 0] > nodes[:, 0].max() - 1e-9]
    placed = [true_shape(drawn.shape, each).place(tip) for each in (Faults(), faults)]
    return float(1e3 * np.linalg.norm(placed[1] - placed[0], axis=1).max())


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_clubs_sides_go_out_by_no_more_than_some_4_and_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    for size, most in ((1, 4.0), (2, 10.0)):
        assert 0.3 * most < _goes_out(drawn, _drawn('clubbed', drawn, size)) < 1.45 * most


@pytest.mark.slow
@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_club_is_seen_by_some_4_and_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    for size, least, most in ((1, 2.5, 6.0), (2, 6.5, 15.0)):
        faults = _drawn('clubbed', drawn, size)
        sunk = 1e3 * max(tip_moves(drawn, plain, faults, plain.shares > 0.99))
        assert least < max(sunk, _goes_out(drawn, faults)) < most


def _striped(setup: Setup) -> Rendering:
    """Return a view of some rows, whose depths tell their columns of samples."""
    depth = np.full((12, 40, 9), np.inf)
    columns = 3 * np.arange(20)[:, None] + np.tile([0, 1, 2], 3)
    depth[:, 10:30] = 0.3 + 1e-3 * columns
    labels = np.where(np.isfinite(depth), 1, -1).astype(np.int64)
    return Rendering(300, 200, depth, labels, np.where(labels > 0, 0.8, 1.0))


def test_each_line_begins_at_a_time_of_its_own(setup: Setup) -> None:
    view, most = _striped(setup), 7.3
    found = jittered(view, setup.camera, most, 41)
    moves = []
    for row in range(200, 212):
        seen = found.depth[row - found.row]
        # All nine samples of a row's pixels, and not one of them twice.
        there = np.isfinite(seen)
        assert np.sort(seen[there]) == pytest.approx(np.sort(view.depth[0, 10:30].ravel()))
        assert np.array_equal(found.labels[row - found.row] > 0, there)
        assert set(found.facing[row - found.row][there]) == {0.8}
        first = np.flatnonzero(there.any(axis=1))[0]
        inside = int(np.argmax(there[first, :3]))
        moves.append(3 * (first + found.column - 310) + inside)
    drawn = np.random.default_rng(41).uniform(-most, most, setup.camera.height)[200:212]
    assert moves == np.round(3.0 * drawn).tolist()
    assert len(set(moves)) > 8
    assert max(np.abs(moves)) <= 22
    assert jittered(view, setup.camera, 0.0, 41) is view


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_lines_jitter_by_some_4_and_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    distance = float(np.linalg.norm(drawn.depth_from_world[:3, 3]))
    for size, most in ((1, 0.004), (2, 0.010)):
        faults = _drawn('jittered', drawn, size)
        assert faults.jittered * distance / drawn.camera.fx == pytest.approx(most, rel=0.16)
        assert faults.jittered_seed > 0
