# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-fifth set has do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_draws import draw_sealed, SEALED
from support.blind_rests import rubber_volumes, tip_moves
from support.blind_views import with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.mirrored import mirrored, turned_over
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentyfifth_outside import TWENTYFIFTH_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYFIFTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_a_bellows_is_wider_and_higher_on_its_crests(setup: Setup) -> None:
    shape = setup.shape
    half_width, half_height = 0.5 * np.array(shape.section)
    waved = true_shape(shape, Faults(ribbed=0.3, ribbed_waves=2.0, ribbed_phase=0.25 * np.pi))
    # A quarter of a wave apart, from a trough on; and one amid the brim, just beyond a crest.
    shares = np.array([0.0, 0.075, 0.3125, 0.4375, 0.5625, 0.6875, 1.0])
    sizes = np.array([0.0, 0.5 * np.cos(0.05 * np.pi), -1.0, 0.0, 1.0, 0.0, np.sqrt(0.5)])
    sizes = 1.0 + 0.3 * sizes
    ahead = shape.clamp + shares * (shape.length - shape.clamp)
    for across, high in ((1.0, 1.0), (-1.0, 0.5), (0.5, -1.0), (0.0, 1.0)):
        place = np.array([across * half_width, high * half_height])
        found = waved.place(np.column_stack([ahead, np.tile(place, (7, 1))]))
        assert found[:, 1:] == pytest.approx(sizes[:, None] * place, abs=1e-12)
        assert found[:, 0] == pytest.approx(ahead)
    held = np.array([[0.4 * shape.clamp, 0.5 * half_width, half_height]])
    assert np.array_equal(waved.place(held), shape.place(held))


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_bellows_has_about_as_much_rubber_as_a_plain_tube(family: str) -> None:
    drawn = draw_sealed(family)
    volumes = rubber_volumes(drawn, _drawn('ribbed', drawn))
    assert volumes[0] == pytest.approx(volumes[1], rel=0.16)


def test_a_bellows_sags_more_and_its_sides_are_elsewhere(setup: Setup, plain: Specimen) -> None:
    tip, edges, moves = plain.shares > 0.99, [], []
    for size in (1, 2):
        faults = _drawn('ribbed', setup, size)
        edges.append(1e3 * faults.ribbed * 0.5 * max(setup.shape.section))
        moves.append(1e3 * max(tip_moves(setup, plain, faults, tip)))
    assert 1.5 < edges[0] < edges[1] < 4.2
    assert 1.5 < moves[0] < moves[1] < 18.0


def test_a_view_turned_over_twice_is_that_view(setup: Setup) -> None:
    random = np.random.default_rng(5)
    depth = random.uniform(0.2, 0.4, (9, 14, 9))
    view = Rendering(301, 222, depth, np.ones(depth.shape, dtype=np.int64), np.ones(depth.shape))
    once = turned_over(view, setup.camera, (3.0, -7.5))
    again = turned_over(once, setup.camera, (3.0, -7.5))
    assert (again.column, again.row) == (view.column, view.row)
    assert np.array_equal(again.depth, depth)
    # The middle of both windows is the place about which one is turned, to half a pixel.
    for axis, (begin, size) in enumerate(((view.column, 14), (view.row, 9))):
        other = (once.column, once.row)[axis]
        middle = 0.5 * (begin + other + size - 1)
        place = (setup.camera.cx + 3.0, setup.camera.cy - 7.5)[axis]
        assert middle == pytest.approx(place, abs=0.2501)


def test_a_lens_tells_a_share_of_what_is_on_the_other_side(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, seen = _drawn('mirrored', setup), []
    x, y = (
        round(2.0 * (c + a))
        for c, a in zip((setup.camera.cx, setup.camera.cy), faults.mirrored_at, strict=True)
    )
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, samples = np.nonzero(there)
        others = {}
        for row, column, sample in zip(rows, columns, samples, strict=True):
            place = (row + right.row, column + right.column, sample)
            others[place] = right.depth[row, column, sample]
        both = 0
        for place, depth in list(others.items())[::7]:
            row, column, sample = place
            other = others.get((y - row, x - column, 8 - sample), depth)
            both += other != depth
            expected = (1.0 - faults.mirrored) * depth + faults.mirrored * other
            found = view.depth[row - right.row, column - right.column, sample]
            assert found == pytest.approx(expected, abs=1e-12)
        seen.append(both)
    assert max(seen) > 500


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_reflecting_lens_moves_ends_of_a_body_by_up_to_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    body, spreads = make_specimen(drawn, Faults(), 0.5), []
    for size in (1, 2):
        faults, found = _drawn('mirrored', drawn, size), []
        for pose, view in enumerate(drawn.observations):
            rest = settle(body, drawn, view, Faults())
            seen, right, there = with_and_without(body, drawn, faults, pose, rest)
            errors = 1e3 * np.abs(seen.depth[there] - right.depth[there])
            found.append(float(np.percentile(errors, 95)))
        spreads.append(max(found))
        assert faults.mirrored <= 0.575
    assert 1.8 < spreads[0] < 6.0
    assert 5.0 < spreads[1] < 15.0


def test_a_lens_that_reflects_nothing_changes_nothing(setup: Setup) -> None:
    depth = np.full((4, 5, 9), 0.3)
    view = Rendering(300, 200, depth, np.ones(depth.shape, dtype=np.int64), depth)
    assert mirrored(view, setup.camera, 0.0) is view
    assert replace(_drawn('mirrored', setup), mirrored=0.0, mirrored_at=(0.0, 0.0)) == Faults()
