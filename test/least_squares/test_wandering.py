# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Steps that follow a gradient's noise end amid their cloud; steps that lead somewhere do not."""

from itertools import pairwise

from diffcal_ros.least_squares.wandering import standard_errors, Wandering
import numpy as np
import pytest

# Of correlated parameters with unlike units: a modulus' logarithm and a shift in metres.
CURVATURE = np.linalg.inv(np.array([[4e-2, -3e-4], [-3e-4, 4e-6]]))
ERRORS = np.array([0.2, 0.002])
CENTRE = np.array([11.5, -0.004])


def _cloud(random, width: float, count: int) -> Wandering:
    """Full steps towards a minimum of which each point knows only where it seems to be."""
    wandering = Wandering()
    points = CENTRE + width * ERRORS * random.uniform(-1.0, 1.0, (count + 1, 2))
    for point, following in pairwise(points):
        wandering.add(point, following - point)
    return wandering


def test_errors_are_those_of_the_inverse() -> None:
    np.testing.assert_allclose(standard_errors(CURVATURE), ERRORS, rtol=1e-9)


def test_what_nothing_depends_on_has_no_error() -> None:
    curvature = np.zeros((3, 3))
    curvature[np.ix_([0, 2], [0, 2])] = CURVATURE
    np.testing.assert_allclose(standard_errors(curvature), [ERRORS[0], 0.0, ERRORS[1]], rtol=1e-9)


def test_a_cloud_is_left_for_its_middle() -> None:
    off = []
    for seed in range(40):
        random = np.random.default_rng(seed)
        middle = _cloud(random, 0.25, 40).middle(CURVATURE)
        assert middle is not None
        off.append((middle - CENTRE) / ERRORS)
    # Uniform over half a standard error: a deviation of 0.14, and of the mean of six 0.06.
    assert np.std(off) == pytest.approx(0.25 / np.sqrt(3.0 * 6.0), rel=0.25)
    assert np.abs(off).max() < 0.25


def test_few_points_are_no_cloud(random) -> None:
    assert _cloud(random, 0.01, 5).middle(CURVATURE) is None
    assert _cloud(random, 0.01, 6).middle(CURVATURE) is not None


def test_small_steps_that_lead_somewhere_go_on() -> None:
    wandering = Wandering()
    for number in range(20):
        # A fifth of a standard error each: less than a cloud's, but all one way.
        wandering.add(CENTRE + number * 0.2 * ERRORS, 0.2 * ERRORS)
    assert wandering.middle(CURVATURE) is None


def test_steps_to_and_fro_across_more_than_an_error_go_on() -> None:
    wandering = Wandering()
    for number in range(20):
        sign = (-1.0) ** number
        wandering.add(CENTRE - 0.75 * sign * ERRORS, 1.5 * sign * ERRORS)
    assert wandering.middle(CURVATURE) is None


def test_only_the_last_points_count() -> None:
    wandering = Wandering()
    wandering.add(CENTRE + 5.0 * ERRORS, -5.0 * ERRORS)
    for _ in range(6):
        wandering.add(CENTRE, np.zeros(2))
    np.testing.assert_allclose(wandering.middle(CURVATURE), CENTRE)
