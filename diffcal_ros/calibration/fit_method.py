# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a calibration asks of its loss: a run from start to end, and doubts about the end."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from diffcal_ros.calibration.residuals.fit_objective import FitObjective
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.results.result import Alternative
from diffcal_ros.least_squares.levenberg_marquardt import Iteration, Minimum
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
OnIteration = Callable[[Iteration], bool]


@dataclass(frozen=True)
class FitEnd:
    """Where a fit ended.

    Attributes:
        minimum: the best that was found.
        gap_start: at the start that was given; NaN where that cannot be simulated.
        alternatives: what else explains the data.
        notes: sentences for a person on what the fit took for granted.
    """

    minimum: Minimum
    gap_start: Gap
    alternatives: tuple[Alternative, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Doubts:
    """What the curvature at a minimum does not say.

    Attributes:
        mesh_shift: how far a better mesh would move the minimum, shape (k,).
        one_sided: names of parameters that the data limit on one side only.
    """

    mesh_shift: FloatArray
    one_sided: tuple[str, ...] = ()


class FitMethod(Protocol):
    """How one kind of loss is fitted."""

    @property
    def objective(self) -> FitObjective:
        """The loss."""

    def likelihood(self, purpose: str) -> RobustObjective:
        """Return the loss as a likelihood, which has a noise and a scale.

        Args:
            purpose: what needs one, for the message.

        Raises:
            InputError: when the loss is none.
        """

    def run(self, start: FloatArray, on_iteration: OnIteration) -> FitEnd:
        """Fit.

        Args:
            start: coordinates, shape (k,).
            on_iteration: told of every accepted step; returns False to stop.

        Raises:
            InputError: when the start shows too little.
            EquilibriumError: when the start cannot be simulated.
            OutOfViewError: when a camera does not see the body there.
        """

    def doubts(self, coordinates: FloatArray) -> Doubts:
        """Return the doubts about a minimum at some coordinates, shape (k,)."""
