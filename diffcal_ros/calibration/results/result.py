# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a calibration found, and its file `result.json`."""

from dataclasses import dataclass, field
import math
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_json_atomically
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.uncertainty.profile import Profile
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

RESULT_FORMAT = 1


@dataclass(frozen=True)
class FittedParameter:
    """One parameter of a fit.

    Attributes:
        name: as in the scene.
        value: in `unit`.
        std_error: statistical and mesh error together, in `unit`.
        mesh_error: the part of mesh and time step in it, in `unit`.
        fine_value: what a mesh without error would give, in `unit`: a material's own; the value
            itself where it is no material's.
        interval_95: of that, in `unit`; of moduli and the like even in the logarithm.
        unit: SI.
        start: where the fit started.
        at_bound: the value is at a bound.
        is_nuisance: not asked for, carried along for honest errors.
    """

    name: str
    value: float
    std_error: float
    mesh_error: float
    unit: str
    start: float
    at_bound: bool = False
    is_nuisance: bool = False
    fine_value: float = math.nan
    interval_95: tuple[float, float] = (math.nan, math.nan)

    @property
    def has_mesh_correction(self) -> bool:
        """Tell whether the material's own value is known apart from what this mesh needs."""
        return math.isfinite(self.fine_value) and self.fine_value != self.value

    @property
    def error_in_model(self) -> float:
        """Standard error of `value` as the parameter of this very mesh, in `unit`.

        Without the mesh's part where that is taken off `fine_value`; whole elsewhere.
        """
        if not self.has_mesh_correction:
            return self.std_error
        return math.sqrt(max(self.std_error**2 - self.mesh_error**2, 0.0))


@dataclass(frozen=True)
class IterationRecord:
    """State after one accepted step.

    Attributes:
        number: 0 for the start.
        loss: value of a whole-image loss; of the robust one the misfit under scales that never
            change, see `RobustObjective.standing`.
        gap: there.
        values: parameters in SI units by name.
        seconds: since the start of the fit.
    """

    number: int
    loss: float
    gap: Gap
    values: dict[str, float]
    seconds: float


@dataclass(frozen=True)
class Alternative:
    """Another place at which the model fits.

    Attributes:
        values: parameters in SI units by name, nuisances too.
        std_errors: statistical, of the same, by name.
        gap: there, in both directions.
        misfit: half chi-square above that of the result, under the result's scales.
        is_as_good: it explains the data about as well as the result.
    """

    values: dict[str, float]
    std_errors: dict[str, float]
    gap: Gap
    misfit: float
    is_as_good: bool

    def as_dict(self) -> dict[str, Any]:
        """Return what `result.json` holds of it."""
        return {
            'parameters': {
                name: {'value': value, 'std_error': self.std_errors[name]}
                for name, value in self.values.items()
            },
            'gap': self.gap.as_dict(),
            'misfit_above_best': self.misfit,
            'explains_about_as_well': self.is_as_good,
        }


@dataclass(frozen=True)
class CalibrationResult:
    """What a calibration found.

    Attributes:
        outcome: how it ended.
        parameters: in order, nuisances last.
        gap_start: gap at the start values.
        gap_end: gap at the fitted values.
        gap_held_out: gap there on frames that were kept from the fit; None without such frames.
        loss: name of the loss.
        history: one record an accepted step, the start first.
        correlation: of the parameters' coordinates, shape (k, k).
        warnings: sentences for a person.
        seconds: of the fit, kernels compiled before.
        profiles: likelihood profiles that were asked for.
        alternatives: other places at which the model fits, the best first.
        details: versions, hashes of inputs, settings.
    """

    outcome: Outcome
    parameters: tuple[FittedParameter, ...]
    gap_start: Gap
    gap_end: Gap
    loss: str
    history: tuple[IterationRecord, ...]
    correlation: FloatArray
    warnings: tuple[str, ...] = ()
    seconds: float = 0.0
    gap_held_out: Gap | None = None
    profiles: tuple[Profile, ...] = ()
    alternatives: tuple[Alternative, ...] = ()
    details: dict[str, Any] = field(default_factory=dict)

    @property
    def iterations(self) -> int:
        """Accepted steps."""
        return self.history[-1].number if self.history else 0

    def __getitem__(self, name: str) -> FittedParameter:
        """Return a parameter by name."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        known = ', '.join(parameter.name for parameter in self.parameters)
        raise KeyError(f'{name!r} was not fitted; fitted are {known}')

    def values(self) -> dict[str, float]:
        """Return the asked-for parameters in SI units by name."""
        return {p.name: p.value for p in self.parameters if not p.is_nuisance}

    def as_dict(self) -> dict[str, Any]:
        """Return what `result.json` holds."""
        return {
            'format': RESULT_FORMAT,
            'outcome': self.outcome.value,
            'remedy': self.outcome.remedy,
            'parameters': {
                p.name: {
                    'value': p.value,
                    'std_error': p.std_error,
                    'mesh_error': p.mesh_error,
                    'fine_mesh_value': p.fine_value,
                    'interval_95': list(p.interval_95),
                    'unit': p.unit,
                    'start': p.start,
                    'at_bound': p.at_bound,
                    'nuisance': p.is_nuisance,
                }
                for p in self.parameters
            },
            'gap': {
                'start': self.gap_start.as_dict(),
                'end': self.gap_end.as_dict(),
                'held_out': self.gap_held_out.as_dict() if self.gap_held_out else None,
            },
            'loss': {
                'name': self.loss,
                'start': self.history[0].loss if self.history else None,
                'end': self.history[-1].loss if self.history else None,
            },
            'iterations': self.iterations,
            'seconds': self.seconds,
            'history': [
                {
                    'iteration': record.number,
                    'loss': record.loss,
                    'gap': record.gap.as_dict(),
                    'parameters': record.values,
                    'seconds': record.seconds,
                }
                for record in self.history
            ],
            'correlation': {
                'names': [p.name for p in self.parameters],
                'matrix': self.correlation.tolist(),
            },
            'profiles': {own.name: own.as_dict() for own in self.profiles},
            'alternatives': [own.as_dict() for own in self.alternatives],
            'warnings': list(self.warnings),
            **self.details,
        }


def save_result(result: CalibrationResult, path: Path) -> None:
    """Write `result.json` whole or not at all.

    Raises:
        InputError: when the disk is full or the folder cannot be written.
    """
    write_json_atomically(path, result.as_dict())
