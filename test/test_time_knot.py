# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Knots of what goes straight from time to time."""

from diffcal_ros.time_knot import knots_between, TimeKnot
import numpy as np
import pytest

TIMES = np.linspace(-1.0, 4.0, 37)


def test_knots_add_up_to_what_goes_straight_between_them() -> None:
    knots = knots_between(0.3, 2.1, 4)
    heights = np.array([1.0, -2.0, 0.5, 3.0])
    summed = sum(own * knot.weights(TIMES) for own, knot in zip(heights, knots, strict=True))
    # Beyond the outermost as there.
    expected = np.interp(TIMES, [0.3, 0.9, 1.5, 2.1], heights)
    np.testing.assert_allclose(summed, expected, atol=1e-12)


def test_a_knot_of_one_frame_counts_in_no_other() -> None:
    knot = TimeKnot(0.7, 0.01)
    np.testing.assert_array_equal(knot.weights(np.array([0.69, 0.7, 0.71])), [0.0, 1.0, 0.0])


@pytest.mark.parametrize('time', [-0.4, 0.5, 1.1, 1.4, 2.0, 3.0])
@pytest.mark.parametrize('step', [1e-3, 1e-4, 1e-5])
def test_slopes_are_those_of_the_weights(time, step) -> None:
    for knot in knots_between(0.3, 2.1, 4):
        around = knot.weights(np.array([time - step, time + step]))
        assert knot.slope(time) == pytest.approx(np.diff(around)[0] / (2.0 * step), abs=1e-9)


def test_a_knot_on_another_axis_counts_at_the_same_moments() -> None:
    knot = knots_between(0.3, 2.1, 4)[2]
    np.testing.assert_allclose(knot.since(0.25).weights(TIMES - 0.25), knot.weights(TIMES))
