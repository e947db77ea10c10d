# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A motion that another one is like: where to begin looking for it."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.fem.motion.frame_reader import hermite_rates, hermite_values
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

FloatArray = NDArray[np.float64]
# Times that agree to this share of a step are the same.
_SAME = 1e-9


@dataclass(frozen=True)
class Path:
    """States of a march.

    Attributes:
        times: since the start [s], ascending, S + 1 of them.
        positions: [m], shape (N, 3) each.
        velocities: [m/s], shape (N, 3) each.
    """

    times: Sequence[float]
    positions: Sequence[FloatArray]
    velocities: Sequence[FloatArray]

    def at(self, time: float) -> tuple[FloatArray, FloatArray] | None:
        """Return positions and velocities at a time since the start [s]; None: past its end."""
        last = len(self.times) - 1
        if last < 1:
            return None
        after = int(np.searchsorted(self.times, time))
        index = min(max(after - 1, 0), last - 1)
        step = self.times[index + 1] - self.times[index]
        fraction = (time - self.times[index]) / step
        if fraction > 1.0 + _SAME:
            return None
        for end in (0, 1):
            if abs(fraction - end) < _SAME:
                return self.positions[index + end], self.velocities[index + end]
        states = [
            kind[index + end] for end in (0, 1) for kind in (self.positions, self.velocities)
        ]
        place, speed = (
            np.asarray(sum(weight * state for weight, state in zip(weights, states, strict=True)))
            for weights in (hermite_values(fraction, step), hermite_rates(fraction, step))
        )
        return place, speed

    def mapped(self, interpolation: csr_matrix) -> 'Path':
        """Return it for other nodes, whose values follow from these, shape (N', N)."""
        positions = [interpolation @ state for state in self.positions]
        return Path(self.times, positions, [interpolation @ state for state in self.velocities])
