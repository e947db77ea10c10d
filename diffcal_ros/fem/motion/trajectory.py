# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an implicit march leaves behind: all that its derivatives need."""

from dataclasses import dataclass, field

from diffcal_ros.fem.motion.generalised_alpha import StepState
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass
class Trajectory:
    """States of a march.

    Attributes:
        times: since the start [s], S + 1 of them.
        steps: sizes of the steps [s], S of them.
        positions: [m], shape (N, 3) each.
        velocities: [m/s], shape (N, 3) each.
        halvings: how often a step had to be halved.
    """

    times: list[float] = field(default_factory=list)
    steps: list[float] = field(default_factory=list)
    positions: list[FloatArray] = field(default_factory=list)
    velocities: list[FloatArray] = field(default_factory=list)
    halvings: int = 0

    def append(self, time: float, state: StepState) -> None:
        """Keep a state."""
        self.times.append(time)
        self.positions.append(state.positions)
        self.velocities.append(state.velocities)
