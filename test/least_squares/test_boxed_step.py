# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A step in a box: limits are kept, and what is free is where the cost is least."""

from diffcal_ros.least_squares.boxed_step import boxed_step
from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
from diffcal_ros.least_squares.normal_equations import Linearisation
import numpy as np
import pytest

NOWHERE = 1e6
EXACT = 1e-9  # Of sums that should vanish, relative to their terms.


def equations(random: np.random.Generator, count: int = 5) -> Linearisation:
    """Make an uneven cost in which coordinates depend on one another."""
    jacobian = random.normal(size=(12, count)) * 10.0 ** random.uniform(-1, 1, count)
    curvature = jacobian.T @ jacobian
    negative_gradient = jacobian.T @ random.normal(size=12)
    nothing = np.zeros_like(curvature)
    return Linearisation(0.0, negative_gradient, curvature, nothing, nothing)


def take(linear: Linearisation, longest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the step without limits and the one within them."""
    here = np.zeros(len(longest))
    bounds = (here - NOWHERE, here + NOWHERE)
    free = gauss_newton_step(linear, here, *bounds)
    return free, boxed_step(linear, here, bounds, free, longest)


def test_a_step_within_the_limits_stays(random):
    linear = equations(random)
    free, boxed = take(linear, np.full(5, NOWHERE))
    np.testing.assert_array_equal(boxed, free)


@pytest.mark.parametrize('share', [0.9, 0.3, 0.01])
def test_the_others_go_where_the_cost_is_least_for_them(share, random):
    for _ in range(50):
        linear = equations(random)
        free, _ = take(linear, np.full(5, NOWHERE))
        longest = np.abs(free) * np.where(random.random(5) < 0.5, share, 2.0)
        _, boxed = take(linear, longest)
        assert (np.abs(boxed) <= longest * (1.0 + EXACT)).all()
        is_stopped = np.abs(boxed) >= longest * (1.0 - EXACT)
        left = linear.negative_gradient - linear.curvature @ boxed
        size = np.abs(linear.curvature) @ np.abs(boxed) + np.abs(linear.negative_gradient)
        assert (np.abs(left) <= EXACT * size)[~is_stopped].all()


def test_one_that_is_stopped_does_not_keep_the_others(random):
    linear = equations(random)
    free, _ = take(linear, np.full(5, NOWHERE))
    longest = np.full(5, NOWHERE)
    longest[2] = 1e-3 * abs(free[2])
    _, boxed = take(linear, longest)
    assert abs(boxed[2]) == pytest.approx(longest[2])
    assert np.sign(boxed[2]) == np.sign(free[2])
    others = np.arange(5) != 2
    # Shortened as a whole they would go a thousandth of their way.
    assert (np.abs(boxed[others]) > 0.01 * np.abs(free[others])).all()
