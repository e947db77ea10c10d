# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The optimiser on functions whose minimum is known, with bounds in its way and without."""

from collections.abc import Callable

from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.least_squares.fixed_form import FixedForm
from diffcal_ros.least_squares.levenberg_marquardt import minimise, Minimum, Stop
from diffcal_ros.least_squares.normal_equations import Linearisation
import numpy as np
import pytest

# Residuals are in standard errors: a minimum is found to a small share of one.
_SHARP = 1e4
START = np.array([-1.2, 1.0])
_FREE = (np.full(2, -10.0), np.full(2, 10.0))
_LONGEST = np.full(2, 0.5)
# A search ends with steps of a thousandth of the longest, in two coordinates.
_NEAR = 2 * 1e-3 * 0.5


class Valley(FixedForm):
    """Rosenbrock's curved valley as a sum of squares: its floor leads to (1, 1)."""

    def __init__(self, is_possible: Callable[[np.ndarray], bool] = lambda _: True) -> None:
        self.is_possible = is_possible

    def residuals(self, at: np.ndarray) -> np.ndarray:
        return _SHARP * np.array([10.0 * (at[1] - at[0] ** 2), 1.0 - at[0]])

    def cost(self, at: np.ndarray) -> float:
        if not self.is_possible(at):
            raise EquilibriumError('there is none')
        return 0.5 * float(self.residuals(at) @ self.residuals(at))

    def linearise(self, at: np.ndarray) -> Linearisation:
        jacobian = _SHARP * np.array([[-20.0 * at[0], 10.0], [-1.0, 0.0]])
        curvature = jacobian.T @ jacobian
        negative_gradient = -jacobian.T @ self.residuals(at)
        return Linearisation(self.cost(at), negative_gradient, curvature, curvature, curvature)


def _minimum(objective: Valley, bounds=_FREE, **settings) -> Minimum:
    given = {'max_iterations': 100, **settings}
    return minimise(objective, START, bounds, _LONGEST, **given)


@pytest.mark.parametrize('settings', [{}, {'is_boxed': True}, {'max_doublings': 2}])
def test_the_end_of_a_curved_valley_is_found(settings) -> None:
    found = _minimum(Valley(), **settings)
    assert found.stop is Stop.CONVERGED
    np.testing.assert_allclose(found.coordinates, 1.0, atol=1e-3)


@pytest.mark.parametrize('is_boxed', [False, True])
def test_along_a_bound_it_goes_to_the_least_there(is_boxed) -> None:
    upper = np.array([0.5, 10.0])
    found = _minimum(Valley(), (_FREE[0], upper), is_boxed=is_boxed)
    assert found.stop is Stop.CONVERGED
    np.testing.assert_allclose(found.coordinates, [0.5, 0.25], atol=1e-3)
    assert found.coordinates[0] == 0.5


def test_a_start_beyond_its_bound_is_taken_back_to_it() -> None:
    told = []
    lower = np.array([-1.0, -10.0])
    _minimum(Valley(), (lower, _FREE[1]), on_iteration=lambda one: not told.append(one))
    np.testing.assert_array_equal(told[0].coordinates, [-1.0, 1.0])
    assert all((one.coordinates >= lower).all() for one in told)


def test_no_step_is_longer_than_the_longest() -> None:
    told = []
    _minimum(Valley(), on_iteration=lambda one: not told.append(one.coordinates))
    steps = np.abs(np.diff(told, axis=0))
    assert len(steps) > 3
    assert steps.max() <= 0.5 + 1e-12


def test_what_cannot_be_simulated_is_gone_around_or_given_up() -> None:
    # Beyond a wall there is nothing: where the way leads through it the search ends before it.
    found = _minimum(Valley(lambda at: at[0] < 0.5))
    assert -0.5 < found.coordinates[0] < 0.5
    nowhere = _minimum(Valley(lambda at: bool((at == START).all())))
    assert nowhere.iterations == 0
    np.testing.assert_array_equal(nowhere.coordinates, START)


def test_a_start_that_no_step_leaves_is_no_minimum() -> None:
    nowhere = _minimum(Valley(lambda at: bool((at == START).all())))
    assert nowhere.stop is Stop.STUCK


def test_a_start_beside_a_wall_is_no_minimum_where_the_way_leads_into_it() -> None:
    def is_possible(at: np.ndarray) -> bool:
        return at[0] <= START[0]

    walled = _minimum(Valley(is_possible))
    assert walled.stop is Stop.STUCK


class RoughBowl:
    """A bowl of which each place shows another centre, by `roughness` standard errors at most."""

    is_annealed = True
    centre = np.array([0.3, -0.7])
    curvature = np.linalg.inv(np.array([[0.04, 0.015], [0.015, 0.01]]))

    def __init__(self, roughness: float) -> None:
        self.roughness = roughness

    def offset(self, at: np.ndarray) -> np.ndarray:
        seen = np.sin(1e4 * np.array([at[0] + 2.0 * at[1], 3.0 * at[0] - at[1]]))
        return at - self.centre + self.roughness * np.array([0.2, 0.1]) * seen

    def cost(self, at: np.ndarray) -> float:
        off = at - self.centre
        return 200.0 + 0.5 * float(off @ self.curvature @ off)

    def linearise(self, at: np.ndarray) -> Linearisation:
        negative_gradient = -self.curvature @ self.offset(at)
        return Linearisation(
            self.cost(at), negative_gradient, self.curvature, self.curvature, self.curvature
        )

    def anneal(self, at: np.ndarray) -> None:
        """It has one form."""

    def refine(self, at: np.ndarray) -> bool:
        return False


@pytest.mark.parametrize('roughness', [0.0, 0.2, 0.3])
def test_a_rough_slope_does_not_keep_it_from_converging(roughness) -> None:
    found = _minimum(RoughBowl(roughness), max_iterations=30)
    assert found.stop is Stop.CONVERGED
    errors = np.abs(found.coordinates - RoughBowl.centre) / np.array([0.2, 0.1])
    assert errors.max() < max(0.01, roughness)


def test_a_slope_that_is_rougher_than_an_error_is_not_called_converged() -> None:
    assert _minimum(RoughBowl(3.0), max_iterations=30).stop is not Stop.CONVERGED


class Illusion(RoughBowl):
    """A bowl whose slope leads up, wherever one goes from the start."""

    def __init__(self) -> None:
        super().__init__(0.0)
        self.looks = 0

    def cost(self, at: np.ndarray) -> float:
        self.looks += 1
        return 200.0 if np.array_equal(at, START) else 300.0


@pytest.mark.parametrize(('patience', 'looks'), [(None, 9), (3, 4)])
def test_patience_ends_where_steps_lead_nowhere(patience, looks) -> None:
    illusion = Illusion()
    found = _minimum(illusion, patience=patience)
    assert (found.stop, illusion.looks) == (Stop.CONVERGED, looks)
    np.testing.assert_array_equal(found.coordinates, START)


def test_it_says_when_it_ran_out_and_when_it_was_stopped() -> None:
    short = _minimum(Valley(), max_iterations=2)
    assert (short.stop, short.iterations) == (Stop.EXHAUSTED, 2)
    stopped = _minimum(Valley(), on_iteration=lambda one: one.number < 1)
    assert (stopped.stop, stopped.iterations) == (Stop.INTERRUPTED, 1)


class Trough(Valley):
    """Only the sum of the coordinates is seen: a whole line is best."""

    def residuals(self, at: np.ndarray) -> np.ndarray:
        return _SHARP * np.array([np.exp(0.3 * (at[0] + at[1])) - 2.0])

    def linearise(self, at: np.ndarray) -> Linearisation:
        slope = 0.3 * _SHARP * np.exp(0.3 * (at[0] + at[1]))
        jacobian = np.full((1, 2), slope)
        curvature = jacobian.T @ jacobian
        negative_gradient = -jacobian.T @ self.residuals(at)
        return Linearisation(self.cost(at), negative_gradient, curvature, curvature, curvature)


def test_of_a_line_of_minima_the_nearest_is_found() -> None:
    found = _minimum(Trough())
    assert found.stop is Stop.CONVERGED
    assert found.coordinates.sum() == pytest.approx(np.log(2.0) / 0.3, abs=_NEAR)
    # Nothing draws along the line.
    assert np.diff(found.coordinates) == pytest.approx(np.diff(START))


def test_along_a_line_of_minima_a_bound_leaves_the_rest_to_the_other() -> None:
    upper = np.array([START[0] + 0.1, 10.0])
    found = _minimum(Trough(), (_FREE[0], upper))
    assert found.coordinates[0] <= upper[0]
    assert found.coordinates.sum() == pytest.approx(np.log(2.0) / 0.3, abs=_NEAR)


def test_a_cost_that_is_not_a_number_is_refused_like_one_that_cannot_be_had() -> None:
    class Torn(Valley):
        def cost(self, at: np.ndarray) -> float:
            return super().cost(at) if at[0] < 0.5 else float('nan')

    found = _minimum(Torn())
    assert -0.5 < found.coordinates[0] < 0.5
    assert np.isfinite(found.linearisation.cost)
