# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit a scene's parameters to observations: the one function behind every door."""

from collections.abc import Callable, Sequence
from dataclasses import replace
import time

from diffcal_ros.calibration.contest import Contest
from diffcal_ros.calibration.forward.forward_model import ForwardModel, NOT_SIMULATED
from diffcal_ros.calibration.observations.observation import Observation, pose_covariances
from diffcal_ros.calibration.observations.seen_regions import require_seen_regions
from diffcal_ros.calibration.optimizers.demon import learning_rates, minimise_with_demon
from diffcal_ros.calibration.optimizers.levenberg_marquardt import (
    Iteration,
    minimise,
    Minimum,
    Stop,
)
from diffcal_ros.calibration.outcome import Outcome
from diffcal_ros.calibration.outcome_rules import judge, warn
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.parameters import Kind, make_parameters, ParameterSet
from diffcal_ros.calibration.parameters.slack_cables import barely_pulling, taut_start
from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.image_objective import ImageObjective
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.result import (
    Alternative,
    CalibrationResult,
    FittedParameter,
    IterationRecord,
)
from diffcal_ros.calibration.search.global_search import can_search, GlobalSearch, worth_fitting
from diffcal_ros.calibration.search.mirrored_pose import settle_mirrored
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.uncertainty.uncertainty import (
    estimate_uncertainty,
    MESH_SHIFT_FACTOR,
    Uncertainty,
    Z_95,
)
from diffcal_ros.errors import InputError
from diffcal_ros.scene.fit_names import RIGID_OFFSET
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Progress = Callable[[IterationRecord], bool]

# Doublings of a Gauss-Newton step on a whole-image loss, and Adam's longest step over its.
_IMAGE_DOUBLINGS = 8
_ADAM_SHARE = 0.1
# No interval reaches further in a coordinate: what is not known is not known.
_WIDEST = 50.0


class Calibration:
    """One fit: model, objective and the state between steps.

    Attributes:
        coordinates: of the parameters after the last accepted step, shape (k,); the model stands
            there while `on_iteration` is told of it.
        held_out: observations that are kept from the fit.
    """

    def __init__(
        self,
        scene: Scene,
        observations: Sequence[Observation],
        settings: CalibrationSettings | None = None,
    ) -> None:
        """Prepare the model.

        Args:
            scene: body, clamp, material, priors.
            observations: at least one; they share the parameters.
            settings: how to fit.

        Raises:
            InputError: when there is nothing to fit, or a camera does not see the body.
        """
        self.held_out = tuple(seen for seen in observations if seen.is_held_out)
        observations = [seen for seen in observations if not seen.is_held_out]
        if not observations:
            raise InputError('there is no observation: a calibration needs at least one recording')
        self.scene = scene
        self.settings = settings or CalibrationSettings()
        is_robust = self.settings.loss == 'robust'
        pose_notes: tuple[str, ...] = ()
        if is_robust and self.settings.search:
            observations, pose_notes = settle_mirrored(scene, observations, self.settings)
        fit, own_offset = self._shared_and_own(is_robust)
        self.parameters = make_parameters(
            scene,
            fit,
            pose_covariances=pose_covariances(observations, own_offset) if is_robust else (),
            with_edge_bias=is_robust,
        )
        if not is_robust and (scene.effects or self.parameters.find(Kind.EFFECT)):
            raise InputError(
                f'the loss {self.settings.loss!r} knows no effects: use the robust loss, or take '
                "the effects out of 'fit' and 'effects'"
            )
        self.model = ForwardModel(
            scene,
            observations,
            self.parameters,
            solver=self.settings.solver,
            device=self.settings.device,
            share_tracers=is_robust,
        )
        self.objective: RobustObjective | ImageObjective = (
            RobustObjective(self.model, device=self.settings.device)
            if is_robust
            else ImageObjective(self.model, self.settings.loss)
        )
        self.coordinates = self.parameters.start()
        self._pose_notes = pose_notes
        self._notes: tuple[str, ...] = ()

    def _shared_and_own(self, is_robust: bool) -> tuple[tuple[str, ...], FloatArray | None]:
        """Return what all recordings share, and the prior of an offset of each one's own."""
        offset = self.scene.rigid_offset
        fit = self.scene.fit if self.settings.fit is None else self.settings.fit
        if not offset.each_recording or RIGID_OFFSET not in fit:
            return fit, None
        if not is_robust:
            raise InputError(
                f'the loss {self.settings.loss!r} knows no offset of each recording: use the '
                "robust loss, or take 'each_recording' out of 'rigid_offset'"
            )
        return tuple(name for name in fit if name != RIGID_OFFSET), offset.covariance

    def run(self, on_iteration: Progress | None = None) -> CalibrationResult:
        """Fit, starting from `coordinates`.

        Args:
            on_iteration: told of every accepted step; returns False to stop.

        Raises:
            InputError: when the start cannot be simulated or is out of view.
        """
        begun = time.perf_counter()
        start = self.coordinates
        history: list[IterationRecord] = []

        def tell(iteration: Iteration) -> bool:
            self.coordinates = iteration.coordinates
            gap, loss = self._standing(iteration.coordinates)
            record = IterationRecord(
                number=len(history),
                loss=loss,
                gap=gap,
                values=self.parameters.values(iteration.coordinates),
                seconds=time.perf_counter() - begun,
            )
            history.append(record)
            return on_iteration is None or on_iteration(record)

        try:
            start, self._notes = taut_start(self.model, self.parameters, start)
            self.coordinates = start
            search = self._search(start)
            begins, gap_start = self._beginnings(start, search, tell)
            if isinstance(self.objective, RobustObjective):
                require_seen_regions(self.objective, begins[0])
            minimum = self._minimise(begins[0], tell)
            minimum, alternatives = self._contest(minimum, begins[1:], search, tell)
        except NOT_SIMULATED as error:
            raise InputError(f'the start values cannot be simulated: {error}') from error
        self.coordinates = minimum.coordinates
        seconds = time.perf_counter() - begun
        return self._result(minimum, gap_start, history, seconds, alternatives)

    def _search(self, start: FloatArray) -> GlobalSearch | None:
        """Return the stage that finds starts, where it serves this fit."""
        is_robust = isinstance(self.objective, RobustObjective)
        if not (self.settings.search and is_robust and can_search(self.model)):
            return None
        return GlobalSearch(self.model, start, solver=self.settings.solver)

    def _beginnings(
        self, start: FloatArray, search: GlobalSearch | None, tell: Callable[[Iteration], bool]
    ) -> tuple[list[FloatArray], Gap]:
        """Return where to fit from, the most promising first, and the gap at the start given."""
        if search is None:
            return [start], self.objective.gap(start)
        assert isinstance(self.objective, RobustObjective)
        try:
            gap, misfit = self.objective.standing(start)
        except NOT_SIMULATED:
            gap, misfit = Gap(float('nan'), float('nan'), 0.0, 0), float('inf')
        begins = [basin.coordinates for basin in worth_fitting(search.basins())]
        if not begins:
            return [start], gap
        if misfit <= self._misfit(begins[0]):
            others = [own for own in begins if not search.are_same(own, start)]
            return [start, *others], gap
        if np.isfinite(misfit):
            tell(Iteration(0, start, misfit))
        return begins, gap

    def _misfit(self, coordinates: FloatArray) -> float:
        """Return the misfit under scales that never change, infinite where there is none."""
        assert isinstance(self.objective, RobustObjective)
        try:
            return self.objective.standing(coordinates)[1]
        except NOT_SIMULATED:
            return float('inf')

    def _contest(
        self,
        minimum: Minimum,
        others: Sequence[FloatArray],
        search: GlobalSearch | None,
        tell: Callable[[Iteration], bool],
    ) -> tuple[Minimum, tuple[Alternative, ...]]:
        """Fit from other starts as well, and return the best and what else explains the data."""
        if search is None or not others or minimum.stop is Stop.INTERRUPTED:
            return minimum, ()
        assert isinstance(self.objective, RobustObjective)
        contest = Contest(self.objective, minimum)
        bounds, longest = self.parameters.bounds(), longest_steps(self.parameters)
        for other in others:
            if not contest.is_known(other, search.are_same):
                contest.challenge(other, bounds, longest)
        best = contest.best.minimum
        alternatives = contest.alternatives(self.parameters, search.are_same)
        self.objective.scales = contest.best.scales
        if best is not minimum:
            tell(Iteration(best.iterations, best.coordinates, best.linearisation.cost))
        return best, alternatives

    def unfinished(self, history: Sequence[IterationRecord]) -> CalibrationResult:
        """Return what is known after the last step of a fit that goes on."""
        last = history[-1]
        nothing = float('nan')
        return CalibrationResult(
            outcome=Outcome.INTERRUPTED,
            parameters=tuple(
                FittedParameter(
                    name=p.name,
                    value=last.values[p.name],
                    std_error=nothing,
                    mesh_error=nothing,
                    unit=p.unit,
                    start=p.quantity.start,
                    is_nuisance=p.is_nuisance,
                )
                for p in self.parameters
            ),
            gap_start=history[0].gap,
            gap_end=last.gap,
            loss=self.settings.loss,
            history=tuple(history),
            correlation=np.zeros((0, 0)),
            seconds=last.seconds,
        )

    def _minimise(self, start: FloatArray, tell: Callable[[Iteration], bool]) -> Minimum:
        bounds, settings = self.parameters.bounds(), self.settings
        if settings.optimizer == 'adam_demon':
            assert isinstance(self.objective, ImageObjective)
            return minimise_with_demon(
                self.objective,
                start,
                bounds,
                learning_rates(self.model, start, _ADAM_SHARE * longest_steps(self.parameters)),
                max_iterations=settings.max_iterations or 100,
                on_iteration=tell,
            )
        return minimise(
            self.objective,
            start,
            bounds,
            longest_steps(self.parameters),
            max_iterations=settings.max_iterations or 30,
            max_doublings=0 if settings.loss == 'robust' else _IMAGE_DOUBLINGS,
            is_boxed=any(seen.instant is not None for seen in self.model.observations),
            on_iteration=tell,
        )

    def _standing(self, coordinates: FloatArray) -> tuple[Gap, float]:
        """Return the gap and a figure that falls from step to step."""
        if isinstance(self.objective, ImageObjective):
            return self.objective.gap(coordinates), self.objective.value(coordinates)
        return self.objective.standing(coordinates)

    def _result(
        self,
        minimum: Minimum,
        gap_start: Gap,
        history: list[IterationRecord],
        seconds: float,
        alternatives: tuple[Alternative, ...],
    ) -> CalibrationResult:
        shift = np.zeros(len(self.parameters))
        loose: tuple[str, ...] = ()
        if isinstance(self.objective, RobustObjective):
            loose = barely_pulling(self.objective, self.parameters, minimum.coordinates)
            if self.settings.with_mesh_error:
                shift = self.objective.mesh_shift(minimum.coordinates, solver=self.settings.solver)
        uncertainty = estimate_uncertainty(
            minimum.linearisation, self.parameters, shift, one_sided=loose
        )
        gap_end = self.objective.gap(minimum.coordinates)
        fitted = fitted_parameters(self.parameters, minimum.coordinates, uncertainty)
        is_ambiguous = any(own.is_as_good for own in alternatives)
        outcome = judge(minimum, gap_end, fitted, uncertainty, is_ambiguous=is_ambiguous)
        return CalibrationResult(
            outcome=outcome,
            parameters=fitted,
            gap_start=gap_start,
            gap_end=gap_end,
            loss=self.settings.loss,
            history=tuple(history),
            correlation=uncertainty.correlation,
            warnings=(
                *self._pose_notes,
                *self._notes,
                *warn(outcome, gap_end, fitted, uncertainty),
                *self.model.warnings(),
            ),
            seconds=seconds,
            gap_held_out=self._held_out_gap(minimum.coordinates),
            alternatives=alternatives,
        )

    def model_of_all(self) -> ForwardModel:
        """Return the model of all observations, those that are held out last."""
        if not self.held_out:
            return self.model
        # Frames that were fitted come first, so that camera poses keep their owners.
        return ForwardModel(
            self.scene,
            (*self.model.observations, *self.held_out),
            self.parameters,
            solver=self.settings.solver,
            device=self.settings.device,
        )

    def _held_out_gap(self, coordinates: FloatArray) -> Gap | None:
        """Measure the gap on frames that the fit did not see; None where it cannot be."""
        if not self.held_out:
            return None
        objective = RobustObjective(self.model_of_all(), device=self.settings.device)
        try:
            compared = objective.comparisons(coordinates)[len(self.model.observations) :]
        except NOT_SIMULATED:
            return None  # The fit came there by steps; from scratch there is no way.
        return measure_gap(
            [c.difference for c in compared], [c.counted for c in compared], objective.truncation
        )


def calibrate(
    scene: Scene,
    observations: Sequence[Observation],
    settings: CalibrationSettings | None = None,
    *,
    on_iteration: Progress | None = None,
) -> CalibrationResult:
    """Fit a scene's parameters to observations.

    Args:
        scene: body, clamp, material, priors.
        observations: of one or several postures; they share the parameters.
        settings: how to fit; default: robust loss, Gauss-Newton, what the scene says.
        on_iteration: told of every accepted step; returns False to stop.

    Raises:
        InputError: when something given is wrong; the message says what to do.
    """
    return Calibration(scene, observations, settings).run(on_iteration)


def fitted_parameters(
    parameters: ParameterSet, coordinates: FloatArray, uncertainty: Uncertainty
) -> tuple[FittedParameter, ...]:
    """Turn coordinates and their errors into values and standard errors."""
    lower, upper = parameters.bounds()
    fitted = []
    for place, parameter in enumerate(parameters):
        value = parameter.value(coordinates[place])
        fine, error = coordinates[place], uncertainty.standard_errors[place]
        if parameter.is_logarithmic:  # Of a placement the whole mesh error is doubt.
            fine += np.clip(uncertainty.fine_shift[place], -_WIDEST, _WIDEST)
            error = uncertainty.fine_errors[place]
        reach = min(Z_95 * error, _WIDEST)
        rate = value if parameter.is_logarithmic else 1.0
        fitted.append(
            FittedParameter(
                name=parameter.name,
                value=value,
                std_error=float(rate * uncertainty.standard_errors[place]),
                mesh_error=float(rate * abs(MESH_SHIFT_FACTOR * uncertainty.mesh_shift[place])),
                unit=parameter.unit,
                start=parameter.quantity.start,
                at_bound=bool(
                    coordinates[place] <= lower[place] or coordinates[place] >= upper[place]
                ),
                is_nuisance=parameter.is_nuisance,
                fine_value=parameter.value(fine),
                interval_95=(parameter.value(fine - reach), parameter.value(fine + reach)),
            )
        )
    return tuple(fitted)


def with_details(result: CalibrationResult, **details: object) -> CalibrationResult:
    """Return the result with versions, hashes and the like added."""
    return replace(result, details={**result.details, **details})
