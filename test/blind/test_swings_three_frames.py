# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Clocks, filters and cameras of the set `swings_three` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_camera
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.shutter import drooped, filmed_views
from benchmarks.blind.simulation import Specimen
from benchmarks.blind.smoothing import on_window, smoothed, STEP
from benchmarks.blind.stamping import moments, stamps
from benchmarks.blind.swings_three_forms import SWINGS_THREE_FORMS
from benchmarks.blind.timing import draw_hold, draw_swing, PERIOD, Timing

FORMS = {form.key: form for form in SWINGS_THREE_FORMS}


def _timing() -> Timing:
    return draw_swing(np.random.default_rng(1))


def _view(depth: np.ndarray, row: int = 10, column: int = 20) -> Rendering:
    """Return a view of depths [m], shape (h, w): all nine samples of a pixel alike."""
    whole = np.repeat(depth[..., None], 9, axis=2)
    labels = np.where(np.isfinite(whole), 1, -1)
    return Rendering(column, row, whole, labels, np.ones(whole.shape))


def test_a_computer_stamps_late_what_piled_up_once() -> None:
    faults = Faults(stamps_form='stalled', stamps_late=12.0, stamps_stall=8, stamps_drain=4.0)
    timing = _timing()
    taken, when = np.array(moments(timing, faults)), 1e-9 * np.array(stamps(timing, faults))
    np.testing.assert_allclose(np.diff(taken), PERIOD, atol=1e-9)
    waits = when - taken - timing.release
    expected = np.zeros(17)
    expected[8:12] = [0.012, 0.009, 0.006, 0.003]
    np.testing.assert_allclose(waits, expected, atol=1e-7)
    off = tuple(np.linspace(0.0, 4e-4, 17))
    jittered = stamps(replace(timing, jitter=off), faults)
    np.testing.assert_allclose(1e-9 * np.array(jittered) - when, off, atol=2e-9)


@pytest.mark.parametrize('size', range(3))
def test_a_computer_stalls_while_a_body_swings(setup: Setup, size: int) -> None:
    for seed in range(20):
        timing = draw_swing(np.random.default_rng(seed))
        draw = FORMS['time_offset/stalled'].draw
        faults = Faults(**draw(size, setup, np.random.default_rng(seed)))
        taken, when = np.array(moments(timing, faults)), np.array(stamps(timing, faults))
        waits = 1e-9 * when - taken - timing.release
        is_late = waits > 1e-6
        assert taken[is_late].min() > 0.0
        assert 4 <= is_late.sum() <= 6
        assert (np.diff(when) > 0).all()
        # It is right again before the end.
        assert not is_late[-2:].any()
        assert waits.max() == pytest.approx(1e-3 * faults.stamps_late, abs=1e-7)


def test_a_depth_that_changes_evenly_lags_by_the_kept_over_the_rest() -> None:
    rates = np.array([[0.003, -0.002, 0.0], [0.001, 0.006, -0.007]])
    views = [_view(0.4 + number * rates) for number in range(40)]
    found = smoothed(views, 0.4)
    assert np.array_equal(found[0].depth, views[0].depth)
    lag = found[-1].depth[..., 0] - views[-1].depth[..., 0]
    np.testing.assert_allclose(lag, -0.4 / 0.6 * rates, atol=1e-12)
    # Frame by frame: what is shown is the sum of all before, by powers of what is kept.
    number = 6
    powers = 0.4 ** np.arange(number + 1)
    weights = np.append(0.6 * powers[:-1], powers[-1])
    summed = sum(w * views[number - k].depth for k, w in enumerate(weights))
    np.testing.assert_allclose(found[number].depth, summed, atol=1e-12)


def test_a_filter_leaves_jumps_and_what_was_not_seen_before_as_they_are() -> None:
    first = np.array([[0.30, 0.30, np.inf, 0.30, 0.30]])
    then = np.array([[0.30 + 0.9 * STEP, 0.30 + 1.1 * STEP, 0.33, np.inf, 0.30 - 1.1 * STEP]])
    shown = smoothed([_view(first), _view(then)], 0.5)[1].depth[..., 0]
    expected = then.copy()
    expected[0, 0] = 0.30 + 0.45 * STEP
    np.testing.assert_allclose(shown, expected)
    views = [_view(first), _view(then)]
    assert all(one is two for one, two in zip(smoothed(views, 0.0), views, strict=True))


@pytest.mark.parametrize('shift', [(0, 0), (2, -1), (-1, 3), (-2, -2), (1, 1), (9, 0), (0, -9)])
def test_views_of_other_windows_are_laid_over_each_other(shift: tuple[int, int]) -> None:
    random = np.random.default_rng(1)
    view = _view(random.random((4, 5)), 10, 20)
    other = _view(random.random((3, 6)), 10 + shift[0], 20 + shift[1])
    image = np.full((50, 60, 9), np.inf)
    image[10:14, 20:25] = view.depth
    rows, columns = np.arange(3) + other.row, np.arange(6) + other.column
    np.testing.assert_array_equal(on_window(view, other), image[np.ix_(rows, columns)])


def test_a_filter_smooths_what_is_filmed(setup: Setup, plain: Specimen) -> None:
    timing = replace(_timing(), release=0.02, frame_count=3)
    shown, raw = (
        filmed_views(plain, setup, setup.observations[0], each, timing)
        for each in (Faults(smoothing=0.5), Faults())
    )
    assert np.array_equal(shown[0].depth, raw[0].depth)
    for one, two in zip(shown[1:], raw[1:], strict=True):
        seen = np.isfinite(two.depth)
        assert np.array_equal(seen, np.isfinite(one.depth))
        off = np.abs(one.depth[seen] - two.depth[seen])
        assert 5e-4 < off.max() <= 0.5 * STEP
        # The fixture stands still.
        assert (off == 0.0).any()


def test_a_camera_droops_as_much_again_in_ten_times_as_long() -> None:
    faults = Faults(camera_turn=(-0.5, 0.1, 0.2), camera_hold=2.0)
    found = [drooped(faults, since).camera_turn for since in (0.0, 18.0, 198.0, 1998.0)]
    expected = np.outer(np.arange(4.0), faults.camera_turn)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    # Its rate is that of the law, which is not evenly slower.
    for since in (0.5, 7.0, 40.0):
        rate = drooped(faults, since + 1e-4).camera_turn[0]
        rate = (rate - drooped(faults, since - 1e-4).camera_turn[0]) / 2e-4
        assert rate == pytest.approx(-0.5 / np.log(10.0) / (2.0 + since), rel=1e-5)
    other = Faults(camera_turn=(-0.5, 0.1, 0.2))
    assert drooped(other, 20.0) is other


@pytest.mark.parametrize('size', [1, 2])
def test_a_camera_that_droops_looks_lower_and_turns_about_its_foot(
    setup: Setup, plain: Specimen, size: int
) -> None:
    draw = FORMS['camera_offset/drooping'].draw
    for seed in range(4):
        faults = Faults(**draw(size, setup, np.random.default_rng(seed)))
        camera = true_camera(plain, setup, drooped(faults, 46.0))
        motion = camera @ np.linalg.inv(setup.depth_from_world)
        foot = np.array([faults.camera_foot])
        np.testing.assert_allclose(applied(motion, foot), foot, atol=1e-12)
        ahead = np.array([[0.0, 0.0, 0.33]])
        before, after = (setup.camera.project(each)[0] for each in (ahead, applied(motion, ahead)))
        # What it looked at is higher in its image, by some millimetres there.
        higher = 0.33 * (before - after)[1] / setup.camera.fy
        assert (0.002, 0.005)[size - 1] < higher < (0.007, 0.014)[size - 1]


def test_a_cameras_droop_is_filmed(setup: Setup, plain: Specimen) -> None:
    faults = Faults(camera_turn=(-1.0, 0.0, 0.0), camera_foot=(0.0, 0.05, 0.0), camera_hold=2.0)
    timing = replace(draw_hold(np.random.default_rng(2)), frame_count=3)
    views, quiet = (
        filmed_views(plain, setup, setup.observations[0], each, timing)
        for each in (faults, Faults())
    )
    assert np.array_equal(views[0].depth, quiet[0].depth)
    rows = [_middle_row(two) - _middle_row(one) for one, two in zip(views, quiet, strict=True)]
    # By the turn after two and after four seconds, in pixels.
    turns = np.deg2rad(np.log10([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(rows, setup.camera.fy * turns, rtol=0.25, atol=1e-9)


def _middle_row(view: Rendering) -> float:
    """Return the mean row of what is seen [px]."""
    rows = view.row + np.arange(view.depth.shape[0])
    counts = np.isfinite(view.depth).sum(axis=(1, 2))
    return float(rows @ counts / counts.sum())
