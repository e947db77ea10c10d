# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-sixth set has do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_draws import draw_sealed, SEALED
from support.blind_rests import rubber_volumes, tip_moves
from support.blind_views import spread_of_what_stays, with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.rings import ring_error
from benchmarks.blind.setups import Setup
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentysixth_outside import TWENTYSIXTH_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYSIXTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_a_wholly_round_mould_has_the_sides_of_an_ellipse(setup: Setup) -> None:
    shape = setup.shape
    half = 0.5 * np.array(shape.section)
    round_one = true_shape(shape, Faults(rounded=1.0))
    free = shape.length - shape.clamp
    for one, other in ((1.0, 0.3), (-0.6, 1.0), (0.2, -1.0), (1.0, 1.0), (-1.0, 0.0)):
        place = np.array([[shape.clamp + 0.7 * free, one * half[0], other * half[1]]])
        found = round_one.place(place)[0]
        assert found[0] == place[0, 0]
        # On the sides of the square both squares add up to that of a circle.
        assert np.square(found[1:] / half).sum() == pytest.approx(1.0, abs=1e-12)
        assert np.array_equal(np.sign(found[1:]), np.sign(place[0, 1:]))


@pytest.mark.parametrize('share', [0.25, 0.8])
def test_a_mould_is_round_by_a_share_beyond_its_brim(setup: Setup, share: float) -> None:
    shape = setup.shape
    half = 0.5 * np.array(shape.section)
    free = shape.length - shape.clamp
    partly, wholly = (true_shape(shape, Faults(rounded=each)) for each in (share, 1.0))
    ahead = shape.clamp + np.array([0.0, 0.075, 0.15, 0.6, 1.0]) * free
    places = np.column_stack([ahead, np.tile(half * [0.9, -0.5], (5, 1))])
    plain, most = shape.place(places), wholly.place(places)
    # By as much as the map from which the circle comes, half of it amid the brim.
    mixed = plain + share * (most - plain)
    assert partly.place(places) == pytest.approx(mixed, abs=1e-12)
    inwards = (most - plain)[:, 1:]
    assert not inwards[0].any()
    assert inwards[1] == pytest.approx(0.5 * inwards[4])
    assert inwards[2:] == pytest.approx(np.tile(inwards[4], (3, 1)))
    held = np.array([[0.4 * shape.clamp, 0.5 * half[0], half[1]]])
    assert np.array_equal(partly.place(held), shape.place(held))


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_round_body_lacks_the_edges_of_a_square_one(family: str) -> None:
    drawn = draw_sealed(family)
    lacking = []
    for size in (1, 2):
        volumes = rubber_volumes(drawn, _drawn('rounded', drawn, size))
        lacking.append(1.0 - volumes[0] / volumes[1])
    # Of a whole circle it were a bit more than a fifth.
    assert 0.04 < lacking[0] < lacking[1] < 1.0 - 0.25 * np.pi


def test_a_round_body_sags_more_and_its_edges_are_elsewhere(setup: Setup, plain: Specimen) -> None:
    tip, edges, moves = plain.shares > 0.99, [], []
    for size in (1, 2):
        faults = _drawn('rounded', setup, size)
        edges.append(1e3 * faults.rounded * (1.0 - np.sqrt(0.5)) * np.hypot(*setup.shape.section))
        moves.append(1e3 * max(tip_moves(setup, plain, faults, tip)))
    assert 2.0 < edges[0] < edges[1] < 8.0
    assert 0.7 < moves[0] < moves[1] < 12.0


def test_rings_are_round_and_the_thinner_the_farther_out(setup: Setup) -> None:
    faults = Faults(rings=5.0, rings_at=(4.0, -11.0), rings_radius=70.0, rings_phase=0.6)
    column, row = round(setup.camera.cx) - 200, round(setup.camera.cy) - 150
    depth = np.full((300, 400, 9), 0.3)
    view = Rendering(column, row, depth, np.ones(depth.shape, dtype=np.int64), depth)
    found = np.asarray(ring_error(view, setup, faults))
    assert found.shape == (300, 400, 1)
    middle = np.array([setup.camera.cx + 4.0, setup.camera.cy - 11.0])
    for turns in (0.0, 0.4, 1.0, 2.7):
        expected = 0.005 * np.sin(0.6 + 2.0 * np.pi * turns)
        for angle in np.deg2rad([10.0, 130.0, 255.0]):
            place = middle + 70.0 * np.sqrt(turns) * np.array([np.cos(angle), np.sin(angle)])
            x, y = np.round(place - [column, row]).astype(int)
            # What a pixel's place is off by, times how fast it swings there.
            off = 0.8 * 0.005 * 4.0 * np.pi * (np.sqrt(turns) / 70.0 + 1.0 / 70.0**2)
            assert found[y, x, 0] == pytest.approx(expected, abs=off)
    assert ring_error(view, setup, replace(faults, rings=0.0)) == 0.0


def test_a_window_that_touches_its_lens_errs_alike_in_all_poses(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    spreads = []
    for size in (1, 2):
        faults, found, told = _drawn('rings', setup, size), [], {}
        for pose in range(4):
            seen = with_and_without(plain, setup, faults, pose, rests[pose])
            found.append(spread_of_what_stays(seen, told))
        spreads.append(max(found))
        assert max(found) == pytest.approx(2.0 * abs(faults.rings), rel=0.02)
    assert 6.0 < spreads[0] < 9.0
    assert 14.0 < spreads[1] < 20.0
