# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Clocks and sensors of the set `swings_two` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Setup
from benchmarks.blind.shutter import filmed_views, warmed_up
from benchmarks.blind.simulation import Specimen
from benchmarks.blind.stamping import moments, stamps
from benchmarks.blind.swings_two_forms import SWINGS_TWO_FORMS
from benchmarks.blind.timing import draw_hold, draw_swing, PERIOD, Timing

FORMS = {form.key: form for form in SWINGS_TWO_FORMS}


def _timing() -> Timing:
    return draw_swing(np.random.default_rng(1))


@pytest.mark.parametrize('size', range(3))
@pytest.mark.parametrize('seed', range(4))
def test_a_driver_stamps_what_it_asks_for_next(setup: Setup, size: int, seed: int) -> None:
    draw = FORMS['time_offset/polled'].draw
    faults, timing = Faults(**draw(size, setup, np.random.default_rng(seed))), _timing()
    taken, when = np.array(moments(timing, faults)), 1e-9 * np.array(stamps(timing, faults))
    np.testing.assert_allclose(np.diff(taken), PERIOD, atol=1e-9)
    waits = when - taken - timing.release
    step = 2e-3 * faults.stamps_late
    # It asks at even times, and between two frames at least once.
    asked = np.diff(when) / step
    np.testing.assert_allclose(asked, np.round(asked), atol=1e-5)
    assert np.round(asked).min() >= 1.0
    assert -1e-7 < waits.min() < waits.max() < step + 1e-7
    assert np.ptp(waits) > 0.5 * step
    assert waits[0] == pytest.approx((1.0 - faults.stamps_asked) * step, abs=1e-7)
    late = (2.5e-3, 4e-3), (5.8e-3, 7.5e-3), (9.5e-3, 13.0e-3)
    assert late[size][0] < 0.5 * step < late[size][1]


@pytest.mark.parametrize('late', [9.0, -9.0])
def test_a_clock_that_is_set_stamps_its_first_frames_late(late: float) -> None:
    faults, timing = Faults(stamps_form='set over', stamps_late=late, stamps_set=10), _timing()
    taken, when = np.array(moments(timing, faults)), 1e-9 * np.array(stamps(timing, faults))
    np.testing.assert_allclose(np.diff(taken), PERIOD, atol=1e-9)
    waits = when - taken - timing.release
    np.testing.assert_allclose(waits[:10], 1e-3 * late, atol=1e-7)
    np.testing.assert_allclose(waits[10:], 0.0, atol=1e-7)
    assert (np.diff(when) > 0.0).all()
    # The same on top of what all stamps are off by.
    off = tuple(np.linspace(0.0, 4e-4, 17))
    jittered = stamps(replace(timing, jitter=off), faults)
    np.testing.assert_allclose(1e-9 * np.array(jittered) - when, off, atol=2e-9)


def test_a_clock_is_set_while_a_body_swings(setup: Setup) -> None:
    for seed in range(20):
        timing = draw_swing(np.random.default_rng(seed))
        draw = FORMS['time_offset/set over'].draw
        faults = Faults(**draw(2, setup, np.random.default_rng(seed)))
        swinging = np.array(moments(timing, faults)) > 0.0
        assert swinging[: faults.stamps_set].sum() >= 2
        assert swinging[faults.stamps_set :].sum() >= 4


def test_the_error_of_a_sensor_that_warms_up_falls_by_the_same_share() -> None:
    faults = Faults(depth_form='switched on', depth_bias=4.0, depth_time=15.0)
    left = [warmed_up(faults, since).depth_bias for since in (0.0, 15.0, 30.0, 45.0)]
    np.testing.assert_allclose(left, 4.0 * np.exp(-np.arange(4.0)))
    other = Faults(depth_bias=4.0)
    assert warmed_up(other, 20.0) is other


def test_a_sensor_that_warms_up_errs_alike_on_all_that_it_sees(
    setup: Setup, plain: Specimen
) -> None:
    faults = Faults(depth_form='switched on', depth_bias=4.0, depth_time=15.0)
    timing = replace(draw_hold(np.random.default_rng(2)), frame_count=3)
    views, quiet = (
        filmed_views(plain, setup, setup.observations[0], each, timing)
        for each in (faults, Faults())
    )
    for number, (one, two) in enumerate(zip(views, quiet, strict=True)):
        seen = np.isfinite(two.depth)
        error = one.depth[seen] - two.depth[seen]
        np.testing.assert_allclose(error, 4e-3 * np.exp(-2.0 * number / 15.0), atol=1e-9)
        assert len(set(one.labels[seen])) > 1
