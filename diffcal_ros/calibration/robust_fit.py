# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit by the robust likelihood: from several starts, the best one told with its rivals."""

from collections.abc import Sequence

from diffcal_ros.calibration.contest import Contest
from diffcal_ros.calibration.fit_method import Doubts, FitEnd, OnIteration
from diffcal_ros.calibration.observations.seen_regions import require_seen_regions
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.slack_cables import barely_pulling
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.two_way_comparison import Misfit
from diffcal_ros.calibration.result import Alternative
from diffcal_ros.calibration.search.global_search import can_search, GlobalSearch, worth_fitting
from diffcal_ros.calibration.settings import CalibrationSettings
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

_UNKNOWN = Gap(float('nan'), float('nan'), 0.0, 0)


class RobustFit:
    """Gauss-Newton from the start given and from those that a search finds.

    Attributes:
        objective: the robust loss.
    """

    def __init__(self, objective: RobustObjective, settings: CalibrationSettings) -> None:
        self.objective, self._model, self._settings = objective, objective.model, settings

    def likelihood(self, purpose: str) -> RobustObjective:
        """Return the loss."""
        return self.objective

    def run(self, start: FloatArray, on_iteration: OnIteration) -> FitEnd:
        """Fit, from several starts where that serves."""
        settings, model = self._settings, self._model
        if not (settings.search and can_search(model)):
            gap = self.objective.gap(start)
            require_seen_regions(self.objective, start)
            return FitEnd(self._minimise(start, on_iteration), gap)
        search = GlobalSearch(model, start, solver=settings.solver)
        starts, gap = self._starts(start, search, on_iteration)
        require_seen_regions(self.objective, starts[0])
        minimum = self._minimise(starts[0], on_iteration)
        if len(starts) == 1 or minimum.stop is Stop.INTERRUPTED:
            return FitEnd(minimum, gap)
        best, alternatives = self._contest(minimum, starts[1:], search, on_iteration)
        return FitEnd(best, gap, alternatives)

    def doubts(self, coordinates: FloatArray) -> Doubts:
        """Return what a better mesh would change, and which cables might as well be slack."""
        loose = barely_pulling(self.objective, self._model.parameters, coordinates)
        if not self._settings.with_mesh_error:
            return Doubts(np.zeros_like(coordinates), loose)
        solver = self._settings.solver
        return Doubts(self.objective.mesh_shift(coordinates, solver=solver), loose)

    def _starts(
        self, start: FloatArray, search: GlobalSearch, on_iteration: OnIteration
    ) -> tuple[list[FloatArray], Gap]:
        """Return where to fit from, the most promising first, and the gap at the start given."""
        starts = [basin.coordinates for basin in worth_fitting(search.basins())]
        misfit = self._misfit(start)
        gap = self.objective.gap(start) if misfit is not None else _UNKNOWN
        if not starts:
            return [start], gap
        if misfit is not None:
            found = self._misfit(starts[0])
            if found is None or not misfit.is_worse(found, fraction=0.0):
                others = [own for own in starts if not search.are_same(own, start)]
                return [start, *others], gap
            on_iteration(Iteration(0, start, misfit.left))
        return starts, gap

    def _misfit(self, coordinates: FloatArray) -> Misfit | None:
        """Return the misfit before any fit, None where there is no equilibrium."""
        try:
            return self.objective.misfit_at_start(coordinates)
        except NotSimulatedError:
            return None

    def _contest(
        self,
        minimum: Minimum,
        others: Sequence[FloatArray],
        search: GlobalSearch,
        on_iteration: OnIteration,
    ) -> tuple[Minimum, tuple[Alternative, ...]]:
        """Fit from other starts as well, and return the best and what else explains the data."""
        contest, parameters = Contest(self.objective, minimum), self._model.parameters
        bounds, longest = parameters.bounds(), longest_steps(parameters)
        for other in others:
            if not contest.is_known(other, search.are_same):
                contest.challenge(other, bounds, longest)
        best = contest.best.minimum
        alternatives = contest.alternatives(parameters, search.are_same)
        self.objective = self.objective.under(contest.best.scales)
        if best is not minimum:
            on_iteration(Iteration(best.iterations, best.coordinates, best.linearisation.cost))
        return best, alternatives

    def _minimise(self, start: FloatArray, on_iteration: OnIteration) -> Minimum:
        parameters = self._model.parameters
        return minimise(
            self.objective,
            start,
            parameters.bounds(),
            longest_steps(parameters),
            max_iterations=self._settings.max_iterations or 30,
            is_boxed=self._model.is_moving,
            on_iteration=on_iteration,
        )
