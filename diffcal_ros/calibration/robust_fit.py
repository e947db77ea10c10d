# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fit by the robust likelihood: from several starts, the best one told with its rivals."""

from collections.abc import Sequence

from diffcal_ros.calibration.contest import Contest
from diffcal_ros.calibration.fit_method import Doubts, FitEnd, OnIteration
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.residuals.seen_regions import require_seen_regions
from diffcal_ros.calibration.residuals.two_way_comparison import Misfit
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import Alternative
from diffcal_ros.calibration.results.result_at import result_at
from diffcal_ros.calibration.search.depth_step import (
    contest_with_step,
    may_have_step,
    step_note,
    without_step,
)
from diffcal_ros.calibration.search.global_search import can_search, GlobalSearch, worth_fitting
from diffcal_ros.calibration.search.slack_cables import barely_pulling
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.uncertainty.uncertainty import estimate_uncertainty
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

# Where an answer could not be used, stated deviations of the placement count so many times.
_LEEWAY = 3.0
_UNKNOWN = Gap(float('nan'), float('nan'), 0.0, 0)


class RobustFit:
    """Gauss-Newton from the start given and from those that a search finds.

    Attributes:
        objective: the robust loss; after a fit under the scales of its end, and of a model that
            the fit may have completed.
    """

    def __init__(self, objective: RobustObjective, settings: CalibrationSettings) -> None:
        self.objective, self._settings = objective, settings

    @property
    def _model(self) -> ForwardModel:
        return self.objective.model

    @property
    def _parameters(self) -> ParameterSet:
        return self.objective.parameters

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
        if minimum.stop is Stop.INTERRUPTED:
            return FitEnd(minimum, gap)
        first = contest = Contest(self.objective, minimum)
        self._challenge(contest, starts[1:], search)
        alternatives = contest.alternatives(search.are_same)
        # Who bounds the iterations wants what so many find.
        looks_farther = settings.looks_farther and settings.max_iterations is None
        if looks_farther and not self._may_be_used(contest, alternatives):
            contest, alternatives = self._look_farther(contest, starts[0], search)
        notes = () if contest is first else (step_note(first, contest),)
        best = contest.best
        self.objective = contest.objective.under(best.scales)
        if best.minimum is not minimum:
            end = best.minimum
            on_iteration(Iteration(end.iterations, end.coordinates, end.linearisation.cost))
        return FitEnd(best.minimum, gap, alternatives, notes)

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

    def _challenge(
        self, contest: Contest, starts: Sequence[FloatArray], search: GlobalSearch
    ) -> None:
        """Fit from other starts as well."""
        for start in starts:
            if not contest.is_known(start, search.are_same):
                contest.challenge(start)

    def _may_be_used(self, contest: Contest, others: Sequence[Alternative]) -> bool:
        """Tell whether the best fit so far would be `converged`, its mesh taken for right."""
        best, parameters = contest.best, contest.objective.parameters
        gap = contest.objective.under(best.scales).gap(best.minimum.coordinates)
        nothing = np.zeros(len(parameters))
        result = result_at(
            best.minimum,
            parameters,
            estimate_uncertainty(best.minimum.linearisation, parameters, nothing),
            (gap, gap),
            (),
            loss='robust',
            seconds=0.0,
            is_ambiguous=any(own.is_as_good for own in others),
        )
        return result.outcome is Outcome.CONVERGED

    def _look_farther(
        self, contest: Contest, start: FloatArray, search: GlobalSearch
    ) -> tuple[Contest, tuple[Alternative, ...]]:
        """Return the fits among which a useful one is found, if any is, and what stands beside.

        Either the camera reads one of the materials too far, or the placement is stated wrongly.
        """
        stepped = None
        if may_have_step(self._model.scene, self._parameters):
            stepped = contest_with_step(contest, search.are_same)
        if stepped is not None:
            # Another start is all that it may have been: a step must pay for itself.
            best = stepped.best
            there = without_step(stepped.objective.parameters, best.minimum.coordinates)
            contest.challenge(there, best.scales)
            better, others = self._better(contest, stepped, search)
            if self._may_be_used(better, others):
                return better, others
        self._look_again(contest, start, search)
        return self._better(contest, stepped, search)

    def _better(
        self, contest: Contest, stepped: Contest | None, search: GlobalSearch
    ) -> tuple[Contest, tuple[Alternative, ...]]:
        """Return the fits of the model that explains the images, and what stands beside."""
        if stepped is None or not contest.is_beaten_by(stepped):
            return contest, contest.alternatives(search.are_same)
        parameters = stepped.objective.parameters

        def are_same(one: FloatArray, other: FloatArray) -> bool:
            return search.are_same(without_step(parameters, one), without_step(parameters, other))

        return stepped, stepped.alternatives(are_same)

    def _look_again(self, contest: Contest, start: FloatArray, search: GlobalSearch) -> None:
        """Fit once more with leeway in what is stated of the placement, first to find starts.

        While widths are wide the images count little, and a body that stands two stated deviations
        off is held where it was stated: its modulus makes up for that. Every fit ends under what
        is stated, and the contest compares them so.
        """
        loose = [own.coordinates for own in worth_fitting(search.basins(_LEEWAY))]
        self._challenge(contest, loose, search)
        for begin in (*loose[:1], start):
            contest.challenge(begin, Scales(leeway=_LEEWAY))

    def _minimise(self, start: FloatArray, on_iteration: OnIteration) -> Minimum:
        parameters = self._model.parameters
        return minimise(
            self.objective,
            start,
            parameters.bounds(),
            longest_steps(parameters),
            max_iterations=self._settings.max_iterations or 30,
            is_boxed=self._model.is_moving,
            patience=self._settings.patience if self._model.is_moving else None,
            on_iteration=on_iteration,
        )
