# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Profile likelihood: how much worse the best fit gets as one parameter is held elsewhere.

At each value of the parameter the others are fitted again. The cost itself is rough, as pixels
join and leave; its slope is not, and by the envelope theorem the profile's slope is the partial
derivative of the cost at the constrained minimum. So the profile is the integral of its slope. An
interval of confidence p is where it stays under chi2_1(p) / 2 times the ratio of the variance that
correlated residuals leave to the one that the curvature says (Rotnitzky and Jewell 1990).
"""

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.uncertainty.profile import Profile
from diffcal_ros.calibration.uncertainty.uncertainty import estimate_uncertainty, Z_95
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.least_squares.fixed_form import FixedForm
from diffcal_ros.least_squares.levenberg_marquardt import minimise, Stop
from diffcal_ros.least_squares.normal_equations import Linearisation
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_THRESHOLD = 0.5 * Z_95**2
# Values are tried at these shares of the standard error until the threshold is passed.
_STEP = 0.5
_MOST_STEPS = 16
_GROWTH = 1.25
_MAX_ITERATIONS = 12


class _HeldForm(FixedForm):
    """The objective in the form that the fit ended with."""

    def __init__(self, objective: RobustObjective) -> None:
        self._objective = objective

    def cost(self, coordinates: FloatArray) -> float:
        return self._objective.cost(coordinates)

    def linearise(self, coordinates: FloatArray) -> Linearisation:
        return self._objective.linearise(coordinates)


def check_profiles(fit: Calibration, names: tuple[str, ...]) -> None:
    """Refuse profiles that a fit cannot have.

    Raises:
        InputError: for a name that is not fitted, or a whole-image loss.
    """
    if names:
        fit.likelihood('a profile')
    for name in names:
        if name not in fit.parameters.names:
            raise InputError(
                f'cannot profile {name!r}: fitted are {", ".join(fit.parameters.names)}'
            )


def profile(fit: Calibration, name: str) -> Profile:
    """Profile one parameter of a finished fit.

    Args:
        fit: after `run`.
        name: of the parameter.

    Raises:
        InputError: see `check_profiles`.
    """
    check_profiles(fit, (name,))
    search = _Search(fit, name)
    below, above = search.walk(-1.0), search.walk(1.0)
    points = np.concatenate([below[0][:0:-1], above[0]])
    rises = np.concatenate([below[1][:0:-1], above[1]])
    # The best value may be a little off the fit's end, which stops within a fiftieth of an error.
    parameter = fit.parameters.parameters[search.index]
    ends = [
        -np.inf if below[2] is None else parameter.value(below[2]),
        np.inf if above[2] is None else parameter.value(above[2]),
    ]
    middle, reach = search.best[search.index], Z_95 * search.error
    return Profile(
        name=name,
        unit=parameter.unit,
        values=np.array([parameter.value(point) for point in points]),
        rises=rises,
        low=float(ends[0]),
        high=float(ends[1]),
        laplace=(parameter.value(middle - reach), parameter.value(middle + reach)),
    )


class _Search:
    """Walks from the best value to both sides."""

    def __init__(self, fit: Calibration, name: str) -> None:
        objective = fit.likelihood('a profile')
        self._fit, self._objective = fit, _HeldForm(objective)
        self.index = fit.parameters.names.index(name)
        self.best = fit.coordinates.copy()
        self._linear = objective.linearise(self.best)
        none = np.zeros(len(self.best))
        uncertainty = estimate_uncertainty(self._linear, fit.parameters, none)
        variance = float(uncertainty.statistical[self.index, self.index])
        self.error = float(np.sqrt(variance))
        curved = np.linalg.pinv(self._linear.information + fit.parameters.prior()[1])
        own = float(curved[self.index, self.index])
        # Where the data see nothing, neither number means anything.
        self._threshold = _THRESHOLD * (variance / own if own > 0.0 else 1.0)

    def walk(self, sign: float) -> tuple[FloatArray, FloatArray, float | None]:
        """Go to one side until the threshold is passed.

        Returns:
            Coordinates from the best one on, rises there over the threshold, and where the
            profile passes it; None where it does not within the bounds.
        """
        lower, upper = (bound[self.index] for bound in self._fit.parameters.bounds())
        points, slopes, rises = [self.best[self.index]], [0.0], [0.0]
        coordinates, step = self.best, _STEP * self.error
        for _ in range(_MOST_STEPS):
            point = float(np.clip(points[-1] + sign * step, lower, upper))
            if abs(point - points[-1]) < 1e-9 * max(step, 1e-12):
                break
            try:
                coordinates, slope = self._constrained(coordinates, point)
            except NotSimulatedError:
                break
            length = point - points[-1]
            rises.append(rises[-1] + 0.5 * length * (slopes[-1] + slope) / self._threshold)
            points.append(point)
            slopes.append(slope)
            if rises[-1] > 1.0:
                end = _crossing(points[-2:], rises[-2:], slopes[-2:], self._threshold)
                return np.array(points), np.array(rises), end
            step *= _GROWTH
        return np.array(points), np.array(rises), None

    def _constrained(self, start: FloatArray, point: float) -> tuple[FloatArray, float]:
        """Fit the others with this one held; return them and the profile's slope."""
        lower, upper = (bound.copy() for bound in self._fit.parameters.bounds())
        lower[self.index] = upper[self.index] = point
        begin = start.copy()
        begin[self.index] = point
        found = minimise(
            self._objective,
            begin,
            (lower, upper),
            longest_steps(self._fit.parameters),
            max_iterations=_MAX_ITERATIONS,
        )
        if found.stop is Stop.STUCK:
            raise EquilibriumError(f'no fit with coordinate {point:g} held')
        return found.coordinates, self._slope(found.linearisation)

    def _slope(self, linear: Linearisation) -> float:
        """Return the profile's slope where the others are near their best, to first order.

        Optimisers stop within a share of an error; of strongly correlated parameters, the slope
        would still be off by much.
        """
        others = np.delete(np.arange(len(self.best)), self.index)
        if len(others) == 0:
            return -float(linear.negative_gradient[self.index])
        curvature = linear.curvature[np.ix_(others, others)]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(curvature), 1e-300))
        step, *_ = np.linalg.lstsq(
            curvature * np.outer(scale, scale),
            scale * linear.negative_gradient[others],
            rcond=1e-12,
        )
        follow = float(linear.curvature[self.index, others] @ (scale * step))
        return -(float(linear.negative_gradient[self.index]) - follow)


def _crossing(
    points: list[float], rises: list[float], slopes: list[float], threshold: float
) -> float:
    """Return where a profile passes its threshold between two points, slope linear between."""
    width = points[1] - points[0]
    first, second = slopes[0] / threshold, slopes[1] / threshold
    # rises[0] + first s + (second - first) s^2 / (2 width) = 1.
    square, missing = 0.5 * (second - first) / width, rises[0] - 1.0
    if abs(square) * width**2 < 1e-12:
        return points[0] - missing / first
    root = np.sqrt(max(first**2 - 4.0 * square * missing, 0.0))
    found = [(-first + sign * root) / (2.0 * square) for sign in (1.0, -1.0)]
    inside = [s for s in found if 0.0 <= s / width <= 1.0 + 1e-9]
    return points[0] + (inside[0] if inside else width)
