# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Channels add up to the cost, its slope and its curvature, and to how sure the data are."""

from diffcal_ros.least_squares.normal_equations import Linearisation, NormalEquations, Prior
from diffcal_ros.least_squares.residual_channel import (
    equations,
    linearise,
    ResidualChannel,
    Weights,
)
import numpy as np
import pytest

HERE = np.array([0.4, -0.7, 1.1])
PRIOR = Prior(np.array([0.5, 0.0, -1.0]), np.diag([4.0, 0.0, 0.25]) + 0.1)
WIDTH = 0.6  # Of the robust cost.


def _residuals(at: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """A curved model of some data: residuals and its Jacobian."""
    t = np.linspace(0.1, 2.0, count)
    modelled = at[0] * np.exp(-at[1] * t) + at[2] * t**2
    jacobian = np.stack([np.exp(-at[1] * t), -at[0] * t * np.exp(-at[1] * t), t**2], axis=1)
    return np.sin(3.0 * t) - modelled, jacobian


def _channel(at: np.ndarray, count: int, strength: float) -> ResidualChannel:
    """Weigh them by Cauchy's cost."""
    values, jacobian = _residuals(at, count)
    ratio = (values / WIDTH) ** 2
    weight = strength / (1.0 + ratio)
    true = weight * np.maximum((1.0 - ratio) / (1.0 + ratio), 0.0)
    cost = 0.5 * strength * WIDTH**2 * float(np.log1p(ratio).sum())
    return ResidualChannel(
        values, jacobian, Weights(weight, weight, true, np.full(count, 3.0)), cost
    )


def _whole(at: np.ndarray) -> Linearisation:
    channels = (_channel(at, count, strength) for count, strength in ((40, 2.0), (7, 30.0)))
    return linearise(channels, len(at)).under(PRIOR, at)


@pytest.mark.parametrize('step', [1e-3, 1e-4, 1e-5])
def test_the_descent_is_the_slope_of_the_cost(step: float) -> None:
    for direction in np.eye(3):
        rise = _whole(HERE + step * direction).cost - _whole(HERE - step * direction).cost
        slope = -float(_whole(HERE).negative_gradient @ direction)
        assert rise / (2.0 * step) == pytest.approx(slope, rel=1e-4)


def test_a_step_alone_needs_the_same_sums() -> None:
    channels = [_channel(HERE, 40, 2.0), _channel(HERE, 7, 30.0)]
    short, whole = equations(channels, 3), linearise(channels, 3)
    assert short.cost == whole.cost
    np.testing.assert_array_equal(short.negative_gradient, whole.negative_gradient)
    np.testing.assert_array_equal(short.curvature, whole.curvature)


def test_priors_leave_what_the_data_say_alone() -> None:
    data = linearise([_channel(HERE, 40, 2.0)], 3)
    whole = data.under(PRIOR, HERE)
    off = HERE - PRIOR.mean
    assert whole.cost - data.cost == pytest.approx(0.5 * off @ PRIOR.precision @ off)
    np.testing.assert_allclose(
        whole.negative_gradient - data.negative_gradient, -PRIOR.precision @ off
    )
    np.testing.assert_allclose(whole.curvature - data.curvature, PRIOR.precision)
    np.testing.assert_array_equal(whole.information, data.information)
    np.testing.assert_array_equal(whole.gradient_covariance, data.gradient_covariance)


def test_the_scatter_is_that_of_gradients_of_repeated_residuals(random) -> None:
    # Noise that is the same in three residuals on end: the covariance of the gradient, drawn.
    jacobian = np.repeat(random.normal(size=(30, 2)), 3, axis=0)
    gradients, said = [], np.zeros((2, 2))
    draws = 4000
    for _ in range(draws):
        values = np.repeat(random.normal(size=30), 3)
        weights = Weights(*(np.ones(90) for _ in range(3)), np.full(90, 3.0))
        linear = ResidualChannel(values, jacobian, weights, 0.0).linearise()
        gradients.append(linear.negative_gradient)
        said += linear.gradient_covariance / draws
    scale = np.sqrt(np.outer(np.diag(said), np.diag(said)))
    # Of a covariance from so many draws, four standard errors.
    np.testing.assert_allclose(np.cov(np.transpose(gradients)) / scale, said / scale, atol=0.09)


def test_a_member_adds_to_its_own_coordinates_only() -> None:
    data = linearise([_channel(HERE, 40, 2.0)], 3)
    places = np.array([4, 0, 2])
    wide = data.placed(places, 5)
    # The other route: columns of zeros for the coordinates of others.
    channel = _channel(HERE, 40, 2.0)
    jacobian = np.zeros((40, 5))
    jacobian[:, places] = channel.jacobian
    expected = ResidualChannel(channel.values, jacobian, channel.weights, channel.cost).linearise()
    for name in ('cost', 'negative_gradient', 'curvature', 'information', 'gradient_covariance'):
        np.testing.assert_allclose(getattr(wide, name), getattr(expected, name), rtol=1e-12)
    both = wide + wide.times(2.0)
    np.testing.assert_allclose(both.gradient_covariance, 3.0 * wide.gradient_covariance)
    assert both.cost == pytest.approx(3.0 * wide.cost)


def test_a_minimum_moves_as_its_gradient_changes() -> None:
    jacobian = np.array([[1.0, 2.0], [0.0, 1.0], [3.0, -1.0]])
    values, change = np.array([0.3, -0.2, 0.5]), np.array([0.05, -0.02])
    prior = Prior(np.zeros(2), np.diag([0.5, 0.0]))
    weights = Weights.of_squares(np.array([1.0, 4.0, 0.5]))
    linear = ResidualChannel(values, jacobian, weights, 0.0).linearise()
    curved = linear.curvature + prior.precision
    before = np.linalg.solve(curved, linear.negative_gradient)
    after = np.linalg.solve(curved, linear.negative_gradient - change)
    np.testing.assert_allclose(linear.minimum_shift(change, prior), after - before, rtol=1e-12)


def test_the_gain_of_a_step_is_that_of_a_quadratic() -> None:
    curvature = np.array([[4.0, 1.0], [1.0, 2.0]])
    valley = NormalEquations(3.0, np.array([1.0, -2.0]), curvature)
    best = np.linalg.solve(curvature, valley.negative_gradient)
    assert valley.gain(best) == pytest.approx(0.5 * float(best @ curvature @ best))
    assert valley.gain(0.9 * best) < valley.gain(best) > valley.gain(1.1 * best)
    assert valley.gain(2.0 * best) == pytest.approx(0.0, abs=1e-12)
