# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Passes, windows and stands of the set `swings_five` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.dented_window import plate_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import positions_at
from benchmarks.blind.lurch import lurch_acceleration, lurch_shift
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.rig_motion import rig_at
from benchmarks.blind.setups import Setup
from benchmarks.blind.shutter import filmed_views
from benchmarks.blind.simulation import Specimen
from benchmarks.blind.smoothing import on_window
from benchmarks.blind.stamping import moments
from benchmarks.blind.swings_five_forms import SWINGS_FIVE_FORMS
from benchmarks.blind.timing import draw_swing, PERIOD

FORMS = {form.key: form for form in SWINGS_FIVE_FORMS}
LURCH = Faults(lurched=4.0, lurched_time=0.04, lurched_way=(0.0, 0.6, -0.8))


@pytest.mark.parametrize('late', [8.0, -8.0])
def test_even_rows_are_of_the_first_pass_and_odd_ones_of_the_second(
    setup: Setup, plain: Specimen, late: float
) -> None:
    faults = Faults(stamps_form='interlaced', stamps_late=late)
    timing = replace(draw_swing(np.random.default_rng(1)), release=0.02, frame_count=3)
    view = setup.observations[0]
    shown = filmed_views(plain, setup, view, faults, timing)
    when = np.array(moments(timing, faults))[:, None] + np.array([-0.008, 0.008])
    places = positions_at(plain, setup, view, Faults(), timing, list(when.ravel()))
    for number, image in enumerate(shown):
        passes = [
            on_window(true_rendering(plain, setup, view, Faults(), place), image)
            for place in places[2 * number : 2 * number + 2]
        ]
        odd = ((image.row + np.arange(len(image.depth))) % 2 == 1)[:, None, None]
        np.testing.assert_array_equal(image.depth, np.where(odd, passes[1], passes[0]))
    # Once the body swings, both passes differ.
    both = np.isfinite(passes[0]) & np.isfinite(passes[1])
    assert np.abs(passes[0][both] - passes[1][both]).max() > 2e-4


def test_both_passes_are_over_before_the_next_frame(setup: Setup) -> None:
    late = [
        FORMS['time_offset/interlaced'].draw(2, setup, np.random.default_rng(seed))['stamps_late']
        for seed in range(20)
    ]
    assert 2e-3 * np.abs(late).max() < PERIOD
    assert set(np.sign(late)) == {-1.0, 1.0}


@pytest.mark.parametrize('step', [1e-2, 3e-3, 1e-3])
def test_a_pressed_plate_bears_nothing_between_its_middle_and_its_rim(step: float) -> None:
    """Its bending is biharmonic there, and at the rim it is held level."""

    def curved(share: np.ndarray, way: np.ndarray) -> np.ndarray:
        # The Laplacian of what is the same all around, by differences.
        there = way[1:-1]
        second = (share[2:] - 2.0 * share[1:-1] + share[:-2]) / step**2
        return np.asarray(second + (share[2:] - share[:-2]) / (2.0 * step * there))

    for middle in (0.3, 0.6, 0.9):
        way = middle + step * np.arange(-2, 3)
        once = curved(plate_share(way), way)
        assert abs(curved(once, way[1:-1])[0]) < 0.01 + 2e3 * step**2
    np.testing.assert_allclose(plate_share(np.array([0.0, 1.0, 1.4])), [1.0, 0.0, 0.0], atol=1e-9)
    assert abs(plate_share(np.array([1.0 - step]))[0]) < 3.0 * step**2


def test_depths_err_by_the_dent_where_pixels_look_through_it(
    setup: Setup, plain: Specimen
) -> None:
    dent = Faults(
        depth_form='dented window', depth_bias=4.0, depth_spot=(20.0, -10.0), depth_width=120.0
    )
    place, view = plain.mesh.nodes, setup.observations[0]
    bent, quiet = (true_rendering(plain, setup, view, each, place) for each in (dent, Faults()))
    rows, columns, _ = np.nonzero(np.isfinite(quiet.depth))
    seen = np.isfinite(quiet.depth)
    across = quiet.column + columns - setup.camera.cx - 20.0
    down = quiet.row + rows - setup.camera.cy + 10.0
    expected = 4e-3 * plate_share(np.hypot(across, down) / 120.0)
    np.testing.assert_allclose(bent.depth[seen] - quiet.depth[seen], expected, atol=1e-12)
    assert expected.max() > 3e-3
    assert expected.min() < 1e-3


@pytest.mark.parametrize(('size', 'most'), [(1, 4.0), (2, 9.0)])
def test_dents_have_their_sizes_near_where_a_body_is_seen(
    setup: Setup, size: int, most: float
) -> None:
    for seed in range(10):
        drawn = FORMS['depth_affine/dented window'].draw(size, setup, np.random.default_rng(seed))
        assert abs(drawn['depth_bias']) == pytest.approx(most, rel=0.15)
        assert np.hypot(*drawn['depth_spot']) < drawn['depth_width']


@pytest.mark.parametrize('step', [1e-3, 3e-4, 1e-4])
def test_a_rig_that_lurches_is_drawn_by_its_acceleration(step: float) -> None:
    for time in (0.01, 0.05, 0.13):
        one, two, three = (lurch_shift(LURCH, time + k * step) for k in (-1, 0, 1))
        found = (one - 2.0 * two + three) / step**2
        np.testing.assert_allclose(found, lurch_acceleration(LURCH, time), atol=5e-3)
    assert not lurch_shift(LURCH, -0.01).any()
    assert not lurch_acceleration(LURCH, -0.01).any()
    # It starts from rest, and is as far as it says after twice its time.
    assert np.linalg.norm(lurch_shift(LURCH, step)) < 2e-2 * step
    np.testing.assert_allclose(lurch_shift(LURCH, 0.08), 4e-3 * np.array([0.0, 0.6, -0.8]))


def test_a_body_stays_in_the_room_where_a_rig_lurches(setup: Setup, plain: Specimen) -> None:
    """So soon after the release that nothing is bent yet: only what is held goes along."""
    timing, view = draw_swing(np.random.default_rng(2)), setup.observations[0]
    time, end = 0.004, plain.shares > 0.95
    quiet, moved = (
        positions_at(plain, setup, view, each, timing, [time])[0] for each in (Faults(), LURCH)
    )
    turn = view.world_from_object[:3, :3]
    shift = lurch_shift(LURCH, time)
    there = rig_at(view, LURCH, time).world_from_object[:3, 3] - view.world_from_object[:3, 3]
    np.testing.assert_allclose(there, shift, atol=1e-12)
    left = ((moved - quiet)[end] @ turn.T + shift).mean(axis=0)
    assert np.linalg.norm(left) < 0.1 * np.linalg.norm(shift)
