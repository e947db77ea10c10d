# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Errors on problems whose answer is known."""

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.uncertainty.uncertainty import estimate_uncertainty, MESH_SHIFT_FACTOR
from diffcal_ros.least_squares.normal_equations import Linearisation
import numpy as np
import pytest
from support.scenes import beam_scene


def _linear(
    information: np.ndarray, gradient_covariance: np.ndarray | None = None
) -> Linearisation:
    count = len(information)
    return Linearisation(
        cost=0.0,
        negative_gradient=np.zeros(count),
        curvature=information,
        information=information,
        gradient_covariance=information if gradient_covariance is None else gradient_covariance,
    )


def _parameters(*fit: str):
    return make_parameters(beam_scene(), fit, with_edge_bias=False)


def test_independent_residuals_give_the_inverse_information() -> None:
    information = np.array([[400.0, 30.0], [30.0, 2500.0]])
    found = estimate_uncertainty(
        _linear(information), _parameters('youngs_modulus', 'poissons_ratio'), np.zeros(2)
    )
    np.testing.assert_allclose(found.covariance, np.linalg.inv(information), rtol=1e-9)
    assert found.blind == ()


def test_scattered_gradients_widen_the_errors() -> None:
    # Four residuals that say the same count as one: the gradient scatters twice as far.
    information = np.array([[400.0]])
    found = estimate_uncertainty(
        _linear(information, 4.0 * information), _parameters('youngs_modulus'), np.zeros(1)
    )
    assert found.standard_errors[0] == pytest.approx(2.0 / 20.0)


def test_the_mesh_error_is_added_whole() -> None:
    found = estimate_uncertainty(
        _linear(np.array([[400.0]])), _parameters('youngs_modulus'), np.array([0.1])
    )
    assert found.standard_errors[0] == pytest.approx(np.hypot(0.05, MESH_SHIFT_FACTOR * 0.1))
    assert found.statistical[0, 0] == pytest.approx(0.05**2)


@pytest.mark.parametrize('order', [1.4, 2.0, 4.0])
def test_without_the_mesh_error_the_interval_holds_where_finer_meshes_end(order) -> None:
    # A value that a mesh of size h leaves 0.06 h^p too low, and what one halving shows of it.
    error = 0.06
    shown = error * (1.0 - 0.5**order)
    found = estimate_uncertainty(
        _linear(np.array([[4e6]])), _parameters('youngs_modulus'), np.array([shown])
    )
    assert abs(found.fine_shift[0] - error) < 1.96 * found.fine_errors[0]
    # The sign of the mesh error is known: to take it off is worth more than to widen the error.
    assert found.fine_errors[0] < 0.3 * found.standard_errors[0]
    assert found.fine_errors[0] < error


def test_a_large_mesh_shift_is_known_no_better_than_its_square() -> None:
    found = estimate_uncertainty(
        _linear(np.array([[4e6]])), _parameters('youngs_modulus'), np.array([0.6])
    )
    assert found.fine_errors[0] > 0.5 * 0.6**2


def test_a_blind_combination_is_named_and_the_rest_is_not() -> None:
    # Only the difference of the first two is seen.
    seen = np.array([1.0, -1.0, 0.0])
    information = 1e4 * np.outer(seen, seen) + np.diag([0.0, 0.0, 1e4])
    parameters = _parameters('youngs_modulus', 'density', 'poissons_ratio')
    found = estimate_uncertainty(_linear(information), parameters, np.zeros(3))
    assert set(found.blind) == {'youngs_modulus', 'density'}


@pytest.mark.parametrize('factor', [0.5, 2.0])
def test_coverage_of_a_linear_problem(factor, random) -> None:
    # A straight line through correlated noise: 95 % intervals hold the truth 95 times of 100,
    # when residuals are weighed as what they are worth, whatever noise was assumed.
    count, block, noise = 400, 8, 0.3
    jacobian = random.normal(size=(count // block, 1)).repeat(block, axis=0)
    hits = 0
    for _ in range(300):
        residual = noise * random.normal(size=count // block).repeat(block)
        weight = 1.0 / (factor * noise) ** 2 / block
        information = weight * jacobian.T @ jacobian
        estimate = np.linalg.solve(information, weight * jacobian.T @ residual)
        left = residual - (jacobian @ estimate)
        scatter = (jacobian * ((weight * left) ** 2 * block)[:, None]).T @ jacobian
        found = estimate_uncertainty(
            _linear(information, scatter), _parameters('youngs_modulus'), np.zeros(1)
        )
        hits += abs(estimate[0]) < 1.96 * found.standard_errors[0]
    assert 0.90 <= hits / 300 <= 0.98
