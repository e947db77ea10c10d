# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a gap is large, and at which frequency residuals swing."""

from diffcal_ros.diagnosis.verdict.time_course import _frequency, _means, _words
import numpy as np
import pytest


def test_the_frequency_of_a_swing_with_holes_is_found() -> None:
    times = np.arange(30) / 30.0
    curve = 0.4 + 1.3 * np.sin(2.0 * np.pi * 3.2 * times + 0.4)
    curve[[4, 5, 11, 20]] = np.nan
    # A second of frames tells frequencies to a fraction of one hertz.
    assert _frequency(times, curve) == pytest.approx(3.2, abs=0.15)
    assert _frequency(times[:4], curve[:4]) is None
    assert _frequency(times, np.zeros(30)) is None
    assert _frequency(times, 1.0 - np.exp(-3.0 * times)) is None


def test_times_are_put_in_words() -> None:
    times = np.arange(9) / 10.0
    assert _words(times, 0) == 'early, at 0.000 s'
    assert _words(times, 4) == 'in the middle, at 0.400 s'
    assert _words(times, 8) == 'late, at 0.800 s'


def test_parts_that_are_not_seen_have_no_mean() -> None:
    means = _means(np.array([1.0, 3.0, 5.0]), np.array([0, 0, 2]))
    np.testing.assert_array_equal(means, [2.0, np.nan, 5.0])
