# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""States at the frames' own stamps: cubic Hermite interpolation between steps, and its adjoint.

Positions and velocities at both ends of a step are matched, so that the interpolation errs by the
fourth power of the step: less than integrators of first or second order do.
"""

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Before the first step nothing moves.
_AT_REST = (1.0, 0.0, 0.0, 0.0)


class FrameReader:
    """Collects frames while a march goes by, and hands derivatives by frames back to its steps.

    Attributes:
        frames: node positions [m], shape (F, N, 3), as far as they were collected.
        rates: their derivative by time [m/s], shape (F, N, 3).
    """

    def __init__(self, times: FloatArray, stamps: FloatArray) -> None:
        """Find the step of each frame.

        Args:
            times: of the states since the start [s], ascending, shape (S + 1,).
            stamps: of the frames since the start [s], shape (F,); none after the last state.
        """
        self._uses: dict[int, list[tuple[int, int, float, float]]] = defaultdict(list)
        self.frames = np.zeros(0)
        self.rates = np.zeros(0)
        self.count = len(stamps)
        last = max(len(times) - 2, 0)
        indices = np.clip(np.searchsorted(times, stamps, side='right') - 1, 0, last)
        for frame, (index, stamp) in enumerate(zip(indices, stamps, strict=True)):
            if stamp <= 0.0 or len(times) < 2:
                self._use(int(index), frame, _AT_REST, (0.0,) * 4)
                continue
            step = float(times[index + 1] - times[index])
            fraction = float(stamp - times[index]) / step
            self._use(
                int(index), frame, hermite_values(fraction, step), hermite_rates(fraction, step)
            )

    def _use(
        self, index: int, frame: int, weights: tuple[float, ...], rates: tuple[float, ...]
    ) -> None:
        for end in (0, 1):
            for kind in (0, 1):
                weight, rate = weights[2 * end + kind], rates[2 * end + kind]
                if weight != 0.0 or rate != 0.0:
                    self._uses[index + end].append((frame, kind, weight, rate))

    def begin(self, shape: tuple[int, ...]) -> None:
        """Start collecting states of this shape, such as (N, 3)."""
        self.frames = np.zeros((self.count, *shape))
        self.rates = np.zeros((self.count, *shape))

    def add(self, index: int, positions: FloatArray, velocities: FloatArray) -> None:
        """Add what a state contributes to the frames around it."""
        for frame, kind, weight, rate in self._uses.get(index, ()):
            values = velocities if kind else positions
            self.frames[frame] += weight * values
            self.rates[frame] += rate * values

    def is_used(self, index: int) -> bool:
        """Tell whether any frame reads a state."""
        return index in self._uses

    def add_adjoints(
        self,
        index: int,
        by_frames: FloatArray,
        by_positions: FloatArray,
        by_velocities: FloatArray,
    ) -> None:
        """Add to the derivatives by a state what comes from those by frames (F, N, 3)."""
        for frame, kind, weight, _ in self._uses.get(index, ()):
            target = by_velocities if kind else by_positions
            target += weight * by_frames[frame]


def hermite_values(fraction: float, step: float) -> tuple[float, ...]:
    """Return the weights of position and velocity at the begin, then at the end."""
    rest = 1.0 - fraction
    return (
        rest**2 * (1.0 + 2.0 * fraction),
        step * fraction * rest**2,
        fraction**2 * (3.0 - 2.0 * fraction),
        -step * fraction**2 * rest,
    )


def hermite_rates(fraction: float, step: float) -> tuple[float, ...]:
    """Return the derivatives of these weights by time [1/s]."""
    bend = 6.0 * fraction * (1.0 - fraction) / step
    return (
        -bend,
        (1.0 - fraction) * (1.0 - 3.0 * fraction),
        bend,
        fraction * (3.0 * fraction - 2.0),
    )
