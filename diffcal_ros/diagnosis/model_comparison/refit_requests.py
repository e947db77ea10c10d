# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refits that any process can do: models that add effects to one nominal model."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Protocol

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects, with_effects
from diffcal_ros.diagnosis.patch_fits.patch_fit import AT_FIRST, Pace
from diffcal_ros.diagnosis.patch_fits.refit import MAX_ITERATIONS, Refit, refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Task(Protocol):
    """A refit that any process can do."""

    @property
    def max_iterations(self) -> int:
        """Evaluations of the model at most."""

    @property
    def words(self) -> str:
        """What is being done, for a person."""

    def fit(self, nominal: PatchEvaluator, base: Refit) -> Refit | None:
        """Refit; None where the model cannot be simulated."""

    def is_same(self, other: 'Task') -> bool:
        """Tell whether another task is the same one, so that it finds the same."""


@dataclass(frozen=True)
class RefitRequest:
    """A model that is refitted from the nominal fit.

    Attributes:
        added: effects.
        starts: where amplitudes start, SI units by name; others at zero.
        max_iterations: evaluations of the model at most.
        least_log_evidence: log evidence below which the model is of no use.
        freed: what effects may be besides in single postures and other forms.
        expected: amplitudes that do not start where tangents lead, there, by name: by these it is
            told how large effects may well be.
        pace: of a fit that begins there.
    """

    added: tuple[Candidate, ...]
    starts: dict[str, float]
    max_iterations: int
    least_log_evidence: float = -np.inf
    freed: tuple[Parameter, ...] = ()
    expected: dict[str, float] = field(default_factory=dict)
    pace: Pace = AT_FIRST

    @property
    def words(self) -> str:
        """What is being done, for a person."""
        return f'refitting with {" and ".join(candidate.identifier for candidate in self.added)}'

    def fit(self, nominal: PatchEvaluator, base: Refit) -> Refit | None:
        """Refit; None where the model cannot be simulated."""
        found = try_effects(
            nominal,
            base,
            self.added,
            self.starts,
            max_iterations=self.max_iterations,
            least_log_evidence=self.least_log_evidence,
            freed=self.freed,
            pace=self.pace,
        )
        return None if found is None else found.fit

    def is_same(self, other: Task) -> bool:
        """Tell whether another task is the same refit from the nominal fit."""
        return self == other


@dataclass(frozen=True)
class Continuation:
    """A model that is fitted on from where it stands, to the end.

    Attributes:
        added: effects.
        coordinates: where it stands, shape (k,).
        groups: all patches there; None: they are not known.
        least_log_evidence: log evidence below which the model is of no use.
        freed: what effects are besides in single postures and other forms.
        max_iterations: evaluations of the model at most.
        pace: how its fit got on when it stopped there.
    """

    added: tuple[Candidate, ...]
    coordinates: FloatArray
    groups: Sequence[PatchGroup] | None
    least_log_evidence: float
    freed: tuple[Parameter, ...] = ()
    max_iterations: int = MAX_ITERATIONS
    pace: Pace = AT_FIRST

    @property
    def words(self) -> str:
        """What is being done, for a person."""
        names = sorted(candidate.identifier for candidate in self.added)
        return f'refitting with {" and ".join(names)} to the end'

    def fit(self, nominal: PatchEvaluator, base: Refit) -> Refit | None:
        """Refit; None where the model cannot be simulated."""
        _, evaluator = with_effects(nominal, base, self.added, self.freed)
        with suppress(NotSimulatedError):
            return refit(
                evaluator,
                self.coordinates,
                max_iterations=self.max_iterations,
                least_log_evidence=self.least_log_evidence,
                known=self.groups,
                pace=self.pace,
            )
        return None

    def is_same(self, other: Task) -> bool:
        """Tell whether another task goes on from the same fit in the same way."""
        return (
            isinstance(other, Continuation)
            and self.groups is other.groups
            and np.array_equal(self.coordinates, other.coordinates)
            and self._way == other._way
        )

    @property
    def _way(self) -> tuple[object, ...]:
        return self.added, self.least_log_evidence, self.freed, self.max_iterations, self.pace
