# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a body is followed from frame to frame, and what is known of it after each."""

from dataclasses import dataclass

from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.result import FittedParameter
from diffcal_ros.calibration.tracking.body_change import BodyChange
from diffcal_ros.errors import InputError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_LONGEST = 0.7  # Step of the logarithm of a modulus.


@dataclass(frozen=True)
class TrackerSettings:
    """How to follow.

    Attributes:
        memory: age at which a frame weighs 1/e of the newest [s].
        change: relative change of a modulus or density that is told; other parameters in
            proportion to their longest steps.
    """

    memory: float = 0.5
    change: float = 0.05

    def __post_init__(self) -> None:
        if not self.memory > 0.0 or not self.change > 0.0:
            raise InputError(
                f'memory is {self.memory:g} s and the change to tell {self.change:g}: give '
                'positive numbers'
            )


@dataclass(frozen=True)
class Tracked:
    """What is known after a frame.

    Attributes:
        stamp_ns: of the frame [ns].
        parameters: values and standard errors.
        correlation: of the parameters' coordinates, shape (k, k).
        cost: half chi-square of the frame.
        gap: of the last frame whose gap was measured.
        frames_worth: equally weighted frames that would average as well.
        is_found: the body is where the model says; else the parameters are the last known.
        is_taken: the frame was used; else it contradicts all others, so far.
        change: what it showed, or None.
    """

    stamp_ns: int
    parameters: tuple[FittedParameter, ...]
    correlation: FloatArray
    cost: float
    gap: Gap
    frames_worth: float
    is_found: bool
    is_taken: bool
    change: BodyChange | None

    def values(self) -> dict[str, float]:
        """Return the asked-for parameters in SI units by name."""
        return {p.name: p.value for p in self.parameters if not p.is_nuisance}


def least_changes(parameters: ParameterSet, change: float) -> FloatArray:
    """Return the change of each coordinate that is told, shape (k,).

    Args:
        parameters: what the coordinates mean.
        change: the same as a relative change of a modulus.
    """
    return change * longest_steps(parameters) / _LONGEST
