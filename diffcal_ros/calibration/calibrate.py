# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit a scene's parameters to observations: the one function behind every door."""

from collections.abc import Callable, Sequence
from dataclasses import replace
import time

from diffcal_ros.calibration.fit_method import FitEnd, FitMethod, OnIteration
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.shared_bodies import SharedBodies, StandIn
from diffcal_ros.calibration.observations.observation import Observation, pose_covariances
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.residuals.fit_objective import FitObjective
from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import (
    CalibrationResult,
    FittedParameter,
    IterationRecord,
)
from diffcal_ros.calibration.results.result_at import result_at
from diffcal_ros.calibration.robust_fit import RobustFit
from diffcal_ros.calibration.search.mirrored_pose import choose_mirrored
from diffcal_ros.calibration.search.slack_cables import taut_start
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.uncertainty.uncertainty import estimate_uncertainty
from diffcal_ros.calibration.whole_image.image_fit import ImageFit
from diffcal_ros.calibration.whole_image.image_objective import ImageObjective
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.least_squares.levenberg_marquardt import Iteration
from diffcal_ros.one_blas_thread import blas_on_one_thread
from diffcal_ros.scene.fit_names import RIGID_OFFSET
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Progress = Callable[[IterationRecord], bool]


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
        *,
        stand_in: StandIn | None = None,
    ) -> None:
        """Prepare the model.

        Args:
            scene: body, clamp, material, priors.
            observations: at least one; they share the parameters.
            settings: how to fit.
            stand_in: what simulates the bodies in place of this package, see `SharedBodies`.

        Raises:
            InputError: when there is nothing to fit, or a camera does not see the body.
        """
        self.held_out = tuple(seen for seen in observations if seen.is_held_out)
        observations = [seen for seen in observations if not seen.is_held_out]
        if not observations:
            raise InputError('there is no observation: a calibration needs at least one recording')
        self.settings = settings or CalibrationSettings()
        is_robust = self.settings.loss == 'robust'
        pose_notes: tuple[str, ...] = ()
        if is_robust and self.settings.search:
            observations, pose_notes = choose_mirrored(scene, observations, self.settings)
        fit, own_offset = self._shared_and_own(scene, is_robust)
        parameters = make_parameters(
            scene,
            fit,
            pose_covariances=pose_covariances(observations, own_offset) if is_robust else (),
            with_edge_bias=is_robust,
        )
        if not is_robust and (scene.effects or parameters.find(Kind.EFFECT)):
            raise InputError(
                f'the loss {self.settings.loss!r} knows no effects: use the robust loss, or take '
                "the effects out of 'fit' and 'effects'"
            )
        self._method = self._make_method(scene, parameters, observations, stand_in)
        self.coordinates = parameters.start()
        self._pose_notes = pose_notes
        self._notes: tuple[str, ...] = ()
        self._all: tuple[ForwardModel, ForwardModel] | None = None

    def _make_method(
        self,
        scene: Scene,
        parameters: ParameterSet,
        observations: Sequence[Observation],
        stand_in: StandIn | None,
    ) -> FitMethod:
        settings = self.settings
        solver, device = settings.solver, settings.device
        model = ForwardModel(
            scene,
            observations,
            parameters,
            solver=solver,
            device=device,
            shared=SharedBodies(scene, observations, solver, device, stand_in),
        )
        if settings.loss == 'robust':
            return RobustFit(RobustObjective(model, device=device), settings)
        return ImageFit(ImageObjective(model, settings.loss), settings)

    def _shared_and_own(
        self, scene: Scene, is_robust: bool
    ) -> tuple[tuple[str, ...], FloatArray | None]:
        """Return what all recordings share, and the prior of an offset of each one's own."""
        offset = scene.rigid_offset
        fit = scene.fit if self.settings.fit is None else self.settings.fit
        if not offset.each_recording or RIGID_OFFSET not in fit:
            return fit, None
        if not is_robust:
            raise InputError(
                f'the loss {self.settings.loss!r} knows no offset of each recording: use the '
                "robust loss, or take 'each_recording' out of 'rigid_offset'"
            )
        return tuple(name for name in fit if name != RIGID_OFFSET), offset.covariance

    @property
    def objective(self) -> FitObjective:
        """The loss."""
        return self._method.objective

    @property
    def model(self) -> ForwardModel:
        """The model whose parameters are fitted; a fit may have completed it."""
        return self.objective.model

    @property
    def scene(self) -> Scene:
        """Body, clamp, material and effects of the model."""
        return self.model.scene

    @property
    def parameters(self) -> ParameterSet:
        """What is fitted."""
        return self.model.parameters

    def go_to(self, coordinates: FloatArray, objective: RobustObjective | None = None) -> None:
        """Stand where a fit shall start, or where another one ended.

        Args:
            coordinates: of the parameters, shape (k,).
            objective: of that fit, with a model of the same parameters; None: as it was.
        """
        self.coordinates = coordinates
        if objective is not None:
            self._method = RobustFit(objective, self.settings)

    def likelihood(self, purpose: str) -> RobustObjective:
        """Return the objective for what only a likelihood can tell.

        Args:
            purpose: what needs it, for the message.

        Raises:
            InputError: when the loss is none.
        """
        return self._method.likelihood(purpose)

    @blas_on_one_thread()
    def run(self, on_iteration: Progress | None = None) -> CalibrationResult:
        """Fit, starting from `coordinates`.

        Args:
            on_iteration: told of every accepted step; returns False to stop.

        Raises:
            InputError: when the start cannot be simulated or is out of view.
        """
        begun = time.perf_counter()
        history: list[IterationRecord] = []

        def record_step(iteration: Iteration) -> bool:
            self.coordinates = iteration.coordinates
            gap, loss = self.objective.standing(iteration.coordinates)
            record = IterationRecord(
                number=len(history),
                loss=loss,
                gap=gap,
                values=self.parameters.values(iteration.coordinates),
                seconds=time.perf_counter() - begun,
            )
            if not history:
                self.model.keep(iteration.coordinates)
            history.append(record)
            return on_iteration is None or on_iteration(record)

        end = self._fit(record_step)
        return self._result(end, self._completed(history), time.perf_counter() - begun)

    @blas_on_one_thread()
    def go_to_best(self) -> None:
        """Fit as `run` does; where that ends is all that is asked, not how well it is known."""
        self._fit(lambda _: True)

    def _fit(self, on_iteration: OnIteration) -> FitEnd:
        try:
            taut = taut_start(self.model, self.parameters, self.coordinates)
            self.coordinates, self._notes = taut
            end = self._method.run(self.coordinates, on_iteration)
        except NotSimulatedError as error:
            raise InputError(f'the start values cannot be simulated: {error}') from error
        self.coordinates = end.minimum.coordinates
        return end

    def _completed(self, history: Sequence[IterationRecord]) -> list[IterationRecord]:
        """Return the steps, with the starts of what the fit has added to its model."""
        starts = self.parameters.values(self.parameters.start())
        return [replace(own, values={**starts, **own.values}) for own in history]

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

    def _result(
        self, end: FitEnd, history: list[IterationRecord], seconds: float
    ) -> CalibrationResult:
        minimum = end.minimum
        self.model.keep(minimum.coordinates)
        doubts = self._method.doubts(minimum.coordinates)
        uncertainty = estimate_uncertainty(
            minimum.linearisation,
            self.parameters,
            doubts.mesh_shift,
            one_sided=doubts.one_sided,
        )
        result = result_at(
            minimum,
            self.parameters,
            uncertainty,
            (end.gap_start, self.objective.gap(minimum.coordinates)),
            history,
            loss=self.settings.loss,
            seconds=seconds,
            is_ambiguous=any(own.is_as_good for own in end.alternatives),
        )
        notes = (*self._pose_notes, *self._notes, *end.notes)
        return replace(
            result,
            warnings=(*notes, *result.warnings, *self.model.warnings(minimum.coordinates)),
            gap_held_out=self._held_out_gap(minimum.coordinates),
            alternatives=end.alternatives,
        )

    def model_of_all(self) -> ForwardModel:
        """Return the model of all observations, those that are held out last."""
        if not self.held_out:
            return self.model
        if self._all is not None and self._all[0] is self.model:
            return self._all[1]
        # Frames that were fitted come first, so that camera poses keep their owners.
        model = ForwardModel(
            self.model.scene,
            (*self.model.observations, *self.held_out),
            self.parameters,
            solver=self.settings.solver,
            device=self.settings.device,
        )
        self._all = self.model, model
        return model

    def _held_out_gap(self, coordinates: FloatArray) -> Gap | None:
        """Measure the gap on frames that the fit did not see; None where it cannot be."""
        if not self.held_out:
            return None
        objective = RobustObjective(self.model_of_all(), device=self.settings.device)
        try:
            compared = objective.comparisons(coordinates)[len(self.model.observations) :]
        except NotSimulatedError:
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


def with_details(result: CalibrationResult, **details: object) -> CalibrationResult:
    """Return the result with versions, hashes and the like added."""
    return replace(result, details={**result.details, **details})
