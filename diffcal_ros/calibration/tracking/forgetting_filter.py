# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Many frames as one cost to second order, in which old frames fade.

An information filter: the past is kept as gradient and curvature at one point, the frames
themselves are gone. Each new frame weighs a share a, and what was known weighs 1 - a. That is a
Kalman filter whose process noise widens the covariance of the past by the factor 1 / (1 - a)
before every frame (West and Harrison 1997, section 6.3): nothing has to be known about how a body
may change, only how fast.

The weights add up to one, so that in the end it says what a fit to the fused frames says.
"""

from dataclasses import replace
import math

from diffcal_ros.least_squares.normal_equations import NormalEquations
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SECOND = 1e9  # [ns]


class ForgettingFilter:
    """Weighted mean of the frames' equations around one point.

    Attributes:
        equations: there, without priors.
        count: frames since it was empty.
    """

    def __init__(self, size: int, memory: float) -> None:
        """Start empty.

        Args:
            size: number of coordinates.
            memory: age at which a frame weighs 1/e of the newest [s].
        """
        self.memory = memory
        self._last_ns = 0
        self.equations = NormalEquations.nothing(size)
        self.count = 0
        self._squares = 1.0

    @property
    def frames_worth(self) -> float:
        """How many equally weighted frames would average as well."""
        return 1.0 / self._squares if self.count else 0.0

    def clear(self) -> None:
        """Forget every frame."""
        self.count = 0

    def add(self, frame: NormalEquations, stamp_ns: int, least_fraction: float = 0.0) -> None:
        """Take one more frame; after a gap it weighs the more, as what is old has faded.

        Args:
            frame: at the point of the filter.
            stamp_ns: not before that of the last one [ns].
            least_fraction: that it must weigh, because it says something new.
        """
        age = (stamp_ns - self._last_ns) / _SECOND
        self.count += 1
        fraction = 1.0
        if self.count > 1:
            fraction = max(1.0 - math.exp(-age / self.memory), 1.0 / self.count, least_fraction)
        self._last_ns = stamp_ns
        self.equations = self.equations.times(1.0 - fraction) + frame.times(fraction)
        self._squares = (1.0 - fraction) ** 2 * self._squares + fraction**2

    def move(self, step: FloatArray) -> None:
        """Move the point that everything is around; the curvature is taken along.

        Args:
            step: shape (k,).
        """
        before = self.equations
        self.equations = replace(
            before, negative_gradient=before.negative_gradient - before.curvature @ step
        )
