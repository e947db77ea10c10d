# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Iterations end at their goal, or as soon as they show that it is too far."""

from diffcal_ros.fem.linear_solvers.conjugate_gradient import conjugate_gradient
import numpy as np
import pytest

SIDE = np.sin(np.arange(200.0)) + 0.3


@pytest.mark.parametrize('largest', [1.5, 1e4])
def test_a_pace_that_is_too_slow_is_given_up(largest) -> None:
    stiffness = np.linspace(1.0, largest, len(SIDE))
    products: list[int] = []

    def product(vector: np.ndarray) -> np.ndarray:
        products.append(1)
        return stiffness * vector

    def solve(patience: float) -> np.ndarray | None:
        products.clear()
        return conjugate_gradient(
            product, lambda x: x / largest, SIDE, 1e-10, 1000, patience=patience
        )

    found = solve(np.inf)
    assert found is not None
    np.testing.assert_allclose(found, SIDE / stiffness, atol=1e-9)
    steps_needed = len(products)
    hurried = solve(20.0)
    assert (hurried is None) == (steps_needed > 25)
    assert len(products) <= 25
