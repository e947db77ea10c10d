# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fits from several starts, compared by one figure."""

from collections.abc import Callable
from dataclasses import dataclass

from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.residuals.two_way_comparison import Misfit
from diffcal_ros.calibration.results.result import Alternative
from diffcal_ros.calibration.uncertainty.uncertainty import covariance_of, Z_95
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.least_squares.levenberg_marquardt import (
    Iteration,
    minimise,
    Minimum,
    Stop,
)
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Half chi-square that three standard errors make: what one minimum must be better by.
_CLEARLY_BETTER = 0.5 * 3.0**2
# What a model leaves is not noise alone; of a large cost this share tells nothing.
_INDIFFERENT = 0.1
# Where a body hides behind something, or a neighbour passes for it, the misfit counts what has no
# counterpart in the one or the other way. Another place that leaves less than this share of the
# depth's gap, on this share of the pixels and of the measured body, is not ruled out by it.
_FINER, _SEEN, _EXPLAINED = 0.5, 0.5, 0.5
# Two answers differ where a parameter does by more than this [log], and the other one's is not in
# the interval of the best.
_DIFFERENT = 0.03
# A fit from another start is given up where it has not come near the best by so many steps.
_PATIENCE, _HOPELESS, _MOST_STEPS = 4, 1.0, 30


@dataclass(frozen=True)
class Entry:
    """One fit, and the scales under which it ended."""

    minimum: Minimum
    scales: Scales


class Contest:
    """Holds the best of several fits of one objective, and the others beside it.

    Attributes:
        objective: what is fitted.
        entries: fits, the best first.
    """

    def __init__(self, objective: RobustObjective, first: Minimum | None = None) -> None:
        """Begin with one fit, whose scales the objective has, or with none."""
        self.objective = objective
        self.entries = [] if first is None else [Entry(first, objective.scales)]

    @property
    def _parameters(self) -> ParameterSet:
        return self.objective.parameters

    @property
    def best(self) -> Entry:
        """The best fit."""
        return self.entries[0]

    def is_known(self, coordinates: FloatArray, are_same: Callable[..., bool]) -> bool:
        """Tell whether a place belongs to a fit that was made."""
        return any(are_same(coordinates, own.minimum.coordinates) for own in self.entries)

    def challenge(self, start: FloatArray, scales: Scales | None = None) -> None:
        """Fit from another start, as far as it is worth it; `scales` are what it begins with."""
        trial = self.objective.under(scales or Scales())
        try:
            minimum = minimise(
                trial,
                start,
                self._parameters.bounds(),
                longest_steps(self._parameters),
                max_iterations=_MOST_STEPS,
                on_iteration=self._patience(),
            )
        except NotSimulatedError:
            return
        if minimum.stop in (Stop.CONVERGED, Stop.EXHAUSTED):
            self.entries.append(Entry(minimum, trial.scales))
            self._sort()

    def _patience(self) -> Callable[[Iteration], bool]:
        """Return what gives a fit up that has not come near the best, if there is one yet.

        Raises:
            NotSimulatedError: when the best cannot be simulated from where the model stands.
        """
        if not self.entries:
            return lambda _: True
        yardstick = self.objective.under(self.best.scales)
        lowest = yardstick.misfit(self.best.minimum.coordinates)

        def goes_on(iteration: Iteration) -> bool:
            if iteration.number < _PATIENCE:
                return True
            misfit = yardstick.misfit(iteration.coordinates)
            return not misfit.is_worse(lowest, _HOPELESS, _CLEARLY_BETTER)

        return goes_on

    def alternatives(self, are_same: Callable[..., bool]) -> tuple[Alternative, ...]:
        """Return the other fits, each place once, as they stand under the finest scales."""
        if len(self.entries) == 1:
            return ()
        parameters = self._parameters
        objective, kept = self.objective.under(self._finest()), [self.best.minimum.coordinates]
        best_gap, lowest = objective.gap_and_misfit(kept[0])
        found = []
        for entry in self.entries[1:]:
            there = entry.minimum.coordinates
            if any(are_same(there, known) for known in kept):
                continue
            try:
                gap, misfit = objective.gap_and_misfit(there)
            except NotSimulatedError:
                continue
            kept.append(there)
            is_near = not misfit.is_worse(lowest, _INDIFFERENT, _CLEARLY_BETTER)
            errors = _errors(entry.minimum, parameters)
            found.append(
                Alternative(
                    values=parameters.values(there),
                    std_errors=_in_units(parameters, there, errors),
                    gap=gap,
                    misfit=misfit.above_absence - lowest.above_absence,
                    is_as_good=bool(is_near or _is_finer(gap, best_gap))
                    and self._says_other(there),
                )
            )
        return tuple(found)

    def _finest(self) -> Scales:
        """Return the scales of the fit with the least noise.

        Noise is the data's: where one place leaves little, no other may count as much as noise.
        A fit that was held far off, by a prior or by what stands in front, found a large one, and
        under its own scales would be better than those that meet the data.
        """
        return min(self.entries, key=lambda own: own.scales.depth.noise).scales

    def is_beaten_by(self, other: 'Contest') -> bool:
        """Tell whether the best fit of another model of the same images is clearly better."""
        scales = min(self._finest(), other._finest(), key=lambda own: own.depth.noise)
        here, there = (one._misfit(one.best, scales) for one in (self, other))
        if here is None or there is None:
            return here is None and there is not None
        return here.is_worse(there, _INDIFFERENT, _CLEARLY_BETTER)

    def _misfit(self, entry: Entry, scales: Scales) -> Misfit | None:
        """Return the misfit of a fit; None: no steps lead there again."""
        try:
            return self.objective.under(scales).misfit(entry.minimum.coordinates)
        except NotSimulatedError:
            return None

    def _sort(self) -> None:
        """Order by the misfit under the finest scales.

        A fit that ran out of steps is preferred to one that ended only where it is clearly better:
        of two that lead to one place, the one that arrived stands for it.
        """
        scales = self._finest()

        def rank(own: Entry) -> float:
            misfit = self._misfit(own, scales)
            ran_out = own.minimum.stop is Stop.EXHAUSTED
            handicap = _CLEARLY_BETTER if ran_out else 0.0
            return np.inf if misfit is None else misfit.above_absence + handicap

        self.entries.sort(key=rank)

    def _says_other(self, there: FloatArray) -> bool:
        """Tell whether what is asked for lies outside the best fit's 95 % interval."""
        best, parameters = self.best.minimum, self._parameters
        change = np.abs(there - best.coordinates)
        limits = np.maximum(_DIFFERENT, Z_95 * _errors(best, parameters))
        asked = [
            index
            for index, own in enumerate(parameters)
            if not own.is_nuisance and own.kind is not Kind.RIGID_OFFSET
        ]
        return bool((change > limits)[asked].any())


def _is_finer(gap: Gap, best: Gap) -> bool:
    """Tell whether a gap is far smaller than the best fit's on what both may see."""
    sees_enough = gap.pixels >= _SEEN * best.pixels and gap.explained >= _EXPLAINED
    return sees_enough and gap.median < _FINER * best.median


def _errors(minimum: Minimum, parameters: ParameterSet) -> FloatArray:
    linear = minimum.linearisation
    covariance = covariance_of(linear.information, linear.gradient_covariance, parameters)
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _in_units(
    parameters: ParameterSet, coordinates: FloatArray, errors: FloatArray
) -> dict[str, float]:
    """Return standard errors in SI units by name."""
    return {
        own.name: float(error * (own.value(coordinate) if own.is_logarithmic else 1.0))
        for own, coordinate, error in zip(parameters, coordinates, errors, strict=True)
    }
