# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The generalised-alpha rule (Chung and Hulbert 1993), as Arnold and Bruels 2007 write it.

    x' = x + h v + h^2 ((1/2 - b) a + b a')
    v' = v + h ((1 - g) a + g a')
    (1 - am) a' + am a = (1 - af) A' + af A,     M A' + f(x', v') = 0

Positions and velocities meet the equation of motion at the end of every step; `a` is a filtered
acceleration. Given the step's begin, all but x' is linear in x'.

`a` is the acceleration at a time that lies am - af of a step beside the state's. Where the size of
steps changes, that distance must change with it or the rule falls to first order (Bruels and
Arnold 2008): a - A grows as the step does.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class StepState:
    """State at one time, every part of shape (..., N, 3).

    Attributes:
        positions: [m].
        velocities: [m/s].
        filtered: accelerations a of the rule [m/s^2].
        accelerations: A, which meet the equation of motion [m/s^2].
    """

    positions: FloatArray
    velocities: FloatArray
    filtered: FloatArray
    accelerations: FloatArray


@dataclass(frozen=True)
class StepRule:
    """Coefficients of one step.

    Attributes:
        step: h [s].
        rho_inf: amplitude left of an infinitely fast vibration after a step: 1 keeps all
            vibrations, 0 removes the fastest at once.
        growth: the step over the one before it.
    """

    step: float
    rho_inf: float
    growth: float = 1.0

    @cached_property
    def alpha_m(self) -> float:
        """Return am."""
        return (2.0 * self.rho_inf - 1.0) / (self.rho_inf + 1.0)

    @cached_property
    def alpha_f(self) -> float:
        """Return af."""
        return self.rho_inf / (self.rho_inf + 1.0)

    @cached_property
    def g(self) -> float:
        """Return g, which makes the rule second-order."""
        return 0.5 + self.alpha_f - self.alpha_m

    @cached_property
    def b(self) -> float:
        """Return b, which damps fast vibrations most for what slow ones lose."""
        return 0.25 * (self.g + 0.5) ** 2

    @cached_property
    def pull(self) -> float:
        """Return da'/dx' [1/s^2]."""
        return 1.0 / (self.b * self.step**2)

    @cached_property
    def rate(self) -> float:
        """Return dv'/dx' [1/s]."""
        return self.g / (self.b * self.step)

    @cached_property
    def mixing(self) -> float:
        """Return dA'/da'."""
        return (1.0 - self.alpha_m) / (1.0 - self.alpha_f)

    @cached_property
    def inertia(self) -> float:
        """Return dA'/dx' [1/s^2]."""
        return self.mixing * self.pull

    @cached_property
    def error_fraction(self) -> float:
        """Return the error of x' over h^2 (a' - a), which both grow as the third power of h."""
        return 0.5 * (self.alpha_m - self.alpha_f) + self.b - 1.0 / 6.0

    def filtered_at(self, begin: StepState) -> FloatArray:
        """Return a of a step's begin as a step of this size takes it [m/s^2]."""
        if self.growth == 1.0:
            return begin.filtered
        return begin.accelerations + self.growth * (begin.filtered - begin.accelerations)

    def known(self, begin: StepState) -> StepState:
        """Return what the end would be at x' = 0: the part that the begin decides."""
        h, b, begun = self.step, self.b, self.filtered_at(begin)
        filtered = -(self.pull * (begin.positions + h * begin.velocities) + (0.5 - b) / b * begun)
        velocities = begin.velocities + h * (1.0 - self.g) * begun + h * self.g * filtered
        accelerations = self.mixing * filtered + (
            self.alpha_m * begun - self.alpha_f * begin.accelerations
        ) / (1.0 - self.alpha_f)
        return StepState(np.zeros_like(filtered), velocities, filtered, accelerations)

    def end(self, known: StepState, positions: FloatArray) -> StepState:
        """Return the end of the step for its positions x'."""
        return StepState(
            positions,
            known.velocities + self.rate * positions,
            known.filtered + self.pull * positions,
            known.accelerations + self.inertia * positions,
        )

    def pull_back(self, by_known: StepState) -> StepState:
        """Return the derivative by the begin from that by `known`; positions are not read."""
        h, b = self.step, self.b
        filtered = (
            by_known.filtered
            + self.mixing * by_known.accelerations
            + h * self.g * by_known.velocities
        )
        mixed = by_known.accelerations / (1.0 - self.alpha_f)
        begun = (
            self.alpha_m * mixed
            + h * (1.0 - self.g) * by_known.velocities
            - (0.5 - b) / b * filtered
        )
        return StepState(
            positions=-self.pull * filtered,
            velocities=by_known.velocities - h * self.pull * filtered,
            filtered=self.growth * begun,
            accelerations=(1.0 - self.growth) * begun - self.alpha_f * mixed,
        )
