# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Single steps: bounds, directions that nothing depends on, damping and units."""

from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
from diffcal_ros.least_squares.normal_equations import NormalEquations
import numpy as np
import pytest

LOWER, UPPER = np.full(3, -10.0), np.full(3, 10.0)
JACOBIAN = np.array([[1.0, 0.5, 0.0], [0.2, 2.0, 1.0], [0.0, 0.3, 1.5], [1.0, 1.0, 1.0]])
VALUES = np.array([0.5, -1.0, 2.0, 0.3])


def _equations(jacobian: np.ndarray = JACOBIAN) -> NormalEquations:
    return NormalEquations(0.0, jacobian.T @ VALUES, jacobian.T @ jacobian)


def _step(equations: NormalEquations, here=(0.0, 0.0, 0.0), damping: float = 0.0) -> np.ndarray:
    return gauss_newton_step(equations, np.array(here), LOWER, UPPER, damping)


def test_a_free_step_solves_the_linear_problem() -> None:
    expected, *_ = np.linalg.lstsq(JACOBIAN, VALUES, rcond=None)
    np.testing.assert_allclose(_step(_equations()), expected, rtol=1e-10)


def test_units_do_not_matter() -> None:
    scale = np.array([1e-6, 1.0, 1e5])
    scaled = _step(_equations(JACOBIAN * scale))
    np.testing.assert_allclose(scaled * scale, _step(_equations()), rtol=1e-9)


@pytest.mark.parametrize('place', [0, 1, 2])
def test_a_bound_stops_what_would_go_beyond_and_no_other(place: int) -> None:
    free = _step(_equations())
    here = np.zeros(3)
    here[place] = (UPPER if free[place] > 0.0 else LOWER)[place]
    stopped = _step(_equations(), here)
    others = np.delete(np.arange(3), place)
    expected, *_ = np.linalg.lstsq(JACOBIAN[:, others], VALUES, rcond=None)
    is_outward = _equations().negative_gradient[place] * free[place] > 0.0
    assert (stopped[place] == 0.0) == is_outward
    np.testing.assert_allclose(stopped[others], expected if is_outward else free[others])


def test_inward_from_a_bound_is_free() -> None:
    negative_gradient = _equations().negative_gradient
    here = np.where(negative_gradient > 0.0, LOWER, UPPER)
    np.testing.assert_allclose(_step(_equations(), here), _step(_equations()), rtol=1e-10)


def test_what_nothing_depends_on_stays_and_twins_share_their_step() -> None:
    blind = JACOBIAN.copy()
    blind[:, 1] = 0.0
    step = _step(_equations(blind))
    assert step[1] == pytest.approx(0.0, abs=1e-12)
    expected, *_ = np.linalg.lstsq(JACOBIAN[:, [0, 2]], VALUES, rcond=None)
    np.testing.assert_allclose(step[[0, 2]], expected, rtol=1e-10)
    twins = JACOBIAN.copy()
    twins[:, 1] = twins[:, 0]
    step = _step(_equations(twins))
    assert step[0] == pytest.approx(step[1])
    shared, *_ = np.linalg.lstsq(JACOBIAN[:, [0, 2]], VALUES, rcond=None)
    np.testing.assert_allclose([step[0] + step[1], step[2]], shared, rtol=1e-8)


def test_damping_shortens_and_turns_towards_the_scaled_descent() -> None:
    equations = _equations()
    gains = [equations.gain(_step(equations, damping=damping)) for damping in (0.0, 0.1, 1.0, 1e3)]
    assert (np.diff(gains) < 0.0).all()
    assert gains[-1] > 0.0
    towards = equations.negative_gradient / np.diag(equations.curvature) / 1e6
    np.testing.assert_allclose(_step(equations, damping=1e6), towards, rtol=1e-4)
