# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit a modulus that varies over the body, beside the ordinary parameters."""

from dataclasses import dataclass, replace
import time
from typing import Any

from diffcal_ros.calibration.calibrate import Calibration, Progress
from diffcal_ros.calibration.field.layout import FieldKind, tets_from_unknowns
from diffcal_ros.calibration.field.search import FieldSearch, Posterior
from diffcal_ros.calibration.field.weight_choice import (
    choose_weight,
    fit_under,
    WeightChoice,
    WeightTrial,
)
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult, IterationRecord
from diffcal_ros.calibration.results.result_at import result_at
from diffcal_ros.calibration.uncertainty.uncertainty import (
    estimate_uncertainty,
    MESH_SHIFT_FACTOR,
)
from diffcal_ros.errors import InputError
from diffcal_ros.least_squares.levenberg_marquardt import Minimum, Stop
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A field from fewer pixels on the body would be the regulariser's, not the data's.
LEAST_PIXELS = 1000
_LAST_ROUNDS = 3


@dataclass(frozen=True)
class FieldFit:
    """A fitted field.

    Attributes:
        youngs_modulus: of every tetrahedron [Pa], shape (T,).
        relative_modulus: the same over its region's, effects of the model left aside, shape (T,).
        log_std: standard error of its logarithm, given the smoothness, shape (T,).
        kind: what the field is made of.
        unknown_count: of the field.
        weights: what was tried and taken.
        uniform: result of the fit without a field, from which the field started.
        result: with the field; its moduli are means of the logarithm over their regions.
    """

    youngs_modulus: FloatArray
    relative_modulus: FloatArray
    log_std: FloatArray
    kind: FieldKind
    unknown_count: int
    weights: WeightChoice
    uniform: CalibrationResult
    result: CalibrationResult

    def as_dict(self) -> dict[str, Any]:
        """Return what `result.json` holds of it."""
        low, middle, high = np.percentile(self.youngs_modulus, [5.0, 50.0, 95.0])
        return {
            'kind': self.kind.describe(),
            'unknowns': self.unknown_count,
            'weight': self.weights.trials[self.weights.chosen].fraction,
            'weight_from': self.weights.reason,
            'youngs_modulus_percentiles': {'5': low, '50': middle, '95': high},
            'log_std_median': float(np.median(self.log_std)),
            'gap_without': self.uniform.gap_end.as_dict(),
            'weights': [
                {
                    'weight': trial.fraction,
                    'misfit': trial.misfit,
                    'roughness': trial.roughness,
                    'residual_mm': 1e3 * trial.residual,
                    'gap': trial.gap.as_dict(),
                    'rounds': trial.rounds,
                }
                for trial in self.weights.trials
            ],
        }


def fit_field(
    calibration: Calibration,
    uniform: CalibrationResult,
    kind: FieldKind | None = None,
    *,
    fraction: float | None = None,
    on_iteration: Progress | None = None,
) -> FieldFit:
    """Fit a field beside the ordinary parameters, from where a fit without one ended.

    Args:
        calibration: that was run, with the robust loss; it ends with the field in its model.
        uniform: its result.
        kind: what the field is made of; default: one modulus a tetrahedron.
        fraction: weight of the field's roughness, see `field.search`; None: found automatically.
        on_iteration: told of the fit under every weight; returns False to stop.

    Raises:
        InputError: when too few pixels see the body, or something given is wrong.
    """
    _check(calibration, uniform)
    kind = kind or FieldKind()
    check_field(calibration.scene, kind, fraction)
    history = _History(calibration.parameters, uniform, on_iteration)
    search = FieldSearch(calibration, kind)
    if fraction is None:
        weights = choose_weight(search, _noise(calibration), on_trial=history.add)
    else:
        weights = fit_under(search, fraction)
        history.add(weights.trials[0])
    posterior = _converged(search, weights.trials[weights.chosen].fraction)
    calibration.go_to(search.state.coordinates, search.objective)
    relative = search.objective.model.scene.relative_modulus
    assert relative is not None
    result = _result(calibration, uniform, posterior, history, is_stopped=weights.is_stopped)
    return FieldFit(
        youngs_modulus=calibration.model.material(calibration.coordinates).youngs_modulus,
        relative_modulus=relative,
        log_std=posterior.log_std,
        kind=kind,
        unknown_count=search.unknown_count,
        weights=weights,
        uniform=uniform,
        result=result,
    )


class _History:
    """The steps of the fit without a field, and then every weight that is tried."""

    def __init__(
        self, parameters: ParameterSet, uniform: CalibrationResult, on_iteration: Progress | None
    ) -> None:
        self._begun = time.perf_counter() - uniform.seconds
        self._parameters, self._on_iteration = parameters, on_iteration
        self.records = list(uniform.history)

    @property
    def seconds(self) -> float:
        """Since the fit without a field began."""
        return time.perf_counter() - self._begun

    def add(self, trial: WeightTrial) -> bool:
        """Tell of a weight; return whether to go on."""
        record = IterationRecord(
            number=self.records[-1].number + trial.rounds,
            loss=0.5 * trial.misfit,
            gap=trial.gap,
            values=self._parameters.values(trial.state.coordinates),
            seconds=self.seconds,
        )
        self.records.append(record)
        return self._on_iteration is None or self._on_iteration(record)


def _converged(search: FieldSearch, fraction: float) -> Posterior:
    """Come to rest under the chosen weight, and tell how sure the field is there."""
    search.refine()
    search.fix_unit(fraction)
    search.descend(fraction, _LAST_ROUNDS)
    return search.posterior(fraction)


def check_field(scene: Scene, kind: FieldKind, fraction: float | None) -> None:
    """Refuse what cannot be fitted before anything slow begins.

    Args:
        scene: gives the mesh and whether the body moves.
        kind: what the field is made of.
        fraction: weight of its roughness; None: found automatically.

    Raises:
        InputError: with what to change.
    """
    tets_from_unknowns(scene.mesh, kind)
    if fraction is not None and not 0.0 < fraction <= 1.0:
        raise InputError(f'the weight of the roughness is {fraction:g}: give a share from 0 to 1')
    if any(setup.motion is not None for setup in scene.observations):
        raise InputError(
            "a field is fitted to bodies at rest: leave observations with 'motion' out"
        )


def _check(calibration: Calibration, uniform: CalibrationResult) -> None:
    calibration.likelihood('a field')
    if uniform.outcome in (Outcome.DIVERGED, Outcome.INTERRUPTED):
        raise InputError(
            f'a field starts from a fit without one, and that ended {uniform.outcome.value}: '
            f'{uniform.outcome.remedy}'
        )
    if uniform.gap_end.pixels < LEAST_PIXELS:
        raise InputError(
            f'a field of moduli is asked for with {uniform.gap_end.pixels} pixels on the body: it '
            f'takes at least {LEAST_PIXELS}; bring the camera closer, or fit one modulus a region'
        )


def _noise(calibration: Calibration) -> float:
    """Return the standard deviation of one pixel of the noisiest observation [m]."""
    sensor = calibration.scene.sensor
    stated = float(np.hypot(sensor.noise, sensor.quantization / np.sqrt(12.0)))
    measured = [o.noise for o in calibration.model.observations if np.isfinite(o.noise)]
    return max([stated, *measured])


def _result(
    calibration: Calibration,
    uniform: CalibrationResult,
    posterior: Posterior,
    history: _History,
    *,
    is_stopped: bool,
) -> CalibrationResult:
    """Describe the ordinary parameters and the gap at the search's end."""
    objective, parameters = calibration.likelihood('a field'), calibration.parameters
    coordinates = calibration.coordinates
    linear = objective.linearise(coordinates)
    shift = np.zeros(len(parameters))
    if calibration.settings.with_mesh_error:
        shift = objective.mesh_shift(coordinates, solver=calibration.settings.solver)
    uncertainty = replace(
        estimate_uncertainty(linear, parameters, shift),
        covariance=posterior.covariance + MESH_SHIFT_FACTOR**2 * np.outer(shift, shift),
        statistical=posterior.covariance,
    )
    stop = Stop.INTERRUPTED if is_stopped else Stop.CONVERGED
    found = result_at(
        Minimum(coordinates, linear, 0, stop),
        parameters,
        uncertainty,
        (uniform.gap_start, objective.gap(coordinates)),
        history.records,
        loss=uniform.loss,
        seconds=history.seconds,
    )
    return replace(
        found,
        gap_held_out=uniform.gap_held_out,
        profiles=uniform.profiles,
        alternatives=uniform.alternatives,
        details=uniform.details,
    )
