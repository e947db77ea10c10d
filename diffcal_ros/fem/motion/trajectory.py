# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an implicit march leaves behind: all that its derivatives need."""

from dataclasses import dataclass, field

from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.path import Path
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass
class Trajectory:
    """States of a march.

    Attributes:
        times: since the start [s], S + 1 of them.
        steps: sizes of the steps [s], S of them.
        rungs: how often each of them halves the longest one.
        positions: [m], shape (N, 3) each.
        velocities: [m/s], shape (N, 3) each.
        halvings: how often a step did not converge.
        errors: what each of them is off by, about [m]; empty where that was not asked for.
    """

    times: list[float] = field(default_factory=list)
    steps: list[float] = field(default_factory=list)
    rungs: list[int] = field(default_factory=list)
    positions: list[FloatArray] = field(default_factory=list)
    velocities: list[FloatArray] = field(default_factory=list)
    halvings: int = 0
    errors: list[float] = field(default_factory=list)

    def rule(self, index: int, rho_inf: float) -> StepRule:
        """Return the rule of the step that ends in a state."""
        return StepRule(self.steps[index - 1], rho_inf, self._growth(index, self.steps[index - 1]))

    def next_rule(self, step: float, rho_inf: float) -> StepRule:
        """Return the rule of a step from the last state."""
        return StepRule(step, rho_inf, self._growth(len(self.times), step))

    def _growth(self, index: int, step: float) -> float:
        # A march starts with a = A: there is nothing to grow.
        return step / self.steps[index - 2] if index > 1 else 1.0

    def append(self, time: float, state: StepState) -> None:
        """Keep a state."""
        self.times.append(time)
        self.positions.append(state.positions)
        self.velocities.append(state.velocities)

    @property
    def path(self) -> Path:
        """Where it went."""
        return Path(self.times, self.positions, self.velocities)
