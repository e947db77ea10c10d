# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Gauss-Newton with Levenberg and Marquardt's damping, within bounds."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.least_squares.boxed_step import boxed_step
from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
from diffcal_ros.least_squares.normal_equations import Linearisation
from diffcal_ros.least_squares.wandering import Wandering
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A step that promises less than this (half chi-square) is a tenth of a standard error: left out,
# it adds a hundredth to a variance.
_SMALL_GAIN = 0.5 * 0.1**2
# The cost is rough by this share, as pixels join and leave; the slope is not. So a step is not
# refused for less.
_ROUGHNESS = 0.03
# A step of this share of the longest changes a modulus by less than 0.1 %.
_NEGLIGIBLE = 1e-3
# A coordinate whose step is this share of its longest was stopped there.
_STOPPED = 0.999
_MAX_REJECTIONS = 8
_MAX_BLUNT_REJECTIONS = 2
_FIRST_DAMPING = 1e-2


class Stop(str, Enum):
    """Why an optimiser stopped."""

    CONVERGED = 'converged'
    EXHAUSTED = 'exhausted'
    STUCK = 'stuck'
    INTERRUPTED = 'interrupted'


class Objective(Protocol):
    """What the optimiser needs to know."""

    def cost(self, coordinates: FloatArray) -> float:
        """Return half chi-square."""

    def linearise(self, coordinates: FloatArray) -> Linearisation:
        """Expand the cost to second order."""

    def anneal(self, coordinates: FloatArray) -> None:
        """Sharpen the cost after an accepted step."""

    def refine(self, coordinates: FloatArray) -> bool:
        """Sharpen the cost at a minimum; True when it changed."""

    @property
    def is_annealed(self) -> bool:
        """Tell whether the cost has its final form."""


@dataclass(frozen=True)
class Iteration:
    """State after an accepted step.

    Attributes:
        number: of the step, 0 for the start.
        coordinates: shape (k,).
        cost: half chi-square.
    """

    number: int
    coordinates: FloatArray
    cost: float


@dataclass(frozen=True)
class Minimum:
    """Where an optimiser stopped.

    Attributes:
        coordinates: shape (k,).
        linearisation: there.
        iterations: accepted steps.
        stop: why it stopped.
    """

    coordinates: FloatArray
    linearisation: Linearisation
    iterations: int
    stop: Stop


def minimise(
    objective: Objective,
    start: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    longest_step: FloatArray,
    *,
    max_iterations: int = 30,
    max_doublings: int = 0,
    is_boxed: bool = False,
    patience: int | None = None,
    on_iteration: Callable[[Iteration], bool] | None = None,
) -> Minimum:
    """Find a minimum.

    Args:
        objective: gives cost, gradient and curvature.
        start: coordinates, shape (k,).
        bounds: lower and upper, shape (k,) each.
        longest_step: of each coordinate, shape (k,).
        max_iterations: accepted steps at most.
        max_doublings: how often a good step may be doubled. A whole-image loss falls in
            proportion to the outline's distance, and Gauss-Newton steps it a pixel at a time.
        is_boxed: stop each coordinate at its own longest step, in place of shortening the step as
            a whole; see `boxed_step`.
        patience: so many steps on end that lead nowhere are taken for the end of a rough cost's
            slope; None: only steps that promise little are.
        on_iteration: told of every accepted step; returns False to stop.
    """
    begun = np.clip(start, *bounds)
    search = _Search(objective, begun, bounds, longest_step, max_doublings, is_boxed, patience)
    report = on_iteration or (lambda _: True)
    if not report(search.iteration()):
        return search.minimum(Stop.INTERRUPTED)
    while True:
        step = search.propose()
        if search.is_done(step):
            if not search.anneal():
                return search.minimum(Stop.CONVERGED)
            continue
        if search.end_wandering():
            if not report(search.iteration()):
                return search.minimum(Stop.INTERRUPTED)
            if not search.anneal():
                return search.minimum(Stop.CONVERGED)
            continue
        if search.number >= max_iterations:
            return search.minimum(Stop.EXHAUSTED)
        if search.take(step):
            if not report(search.iteration()):
                return search.minimum(Stop.INTERRUPTED)
        elif search.rejections > _MAX_REJECTIONS:
            return search.minimum(Stop.STUCK)


class _Search:
    """State between steps."""

    def __init__(
        self,
        objective: Objective,
        start: FloatArray,
        bounds: tuple[FloatArray, FloatArray],
        longest_step: FloatArray,
        max_doublings: int,
        is_boxed: bool,
        patience: int | None,
    ) -> None:
        self._patience = patience
        self._objective = objective
        self._lower, self._upper = bounds
        self._longest_step = longest_step
        self._max_doublings = max_doublings
        self._is_boxed = is_boxed
        self._damping = 0.0
        self._last: tuple[FloatArray, FloatArray] | None = None
        self._coordinates = start
        self._linear = objective.linearise(start)
        self._wandering = Wandering()
        self._impossible = 0
        self.number = 0
        self.rejections = 0

    def iteration(self) -> Iteration:
        """Return the state for who follows the fit."""
        return Iteration(self.number, self._coordinates, self._linear.cost)

    def minimum(self, stop: Stop) -> Minimum:
        """Return the state as the end."""
        return Minimum(self._coordinates, self._linear, self.number, stop)

    def propose(self) -> FloatArray:
        """Return the next step."""
        step = self._gauss_newton(self._damping)
        if self._last is not None and self.rejections == 0:
            step *= _secant_fraction(self._linear, step, *self._last)
        if self._is_boxed:
            bounds = (self._lower, self._upper)
            return boxed_step(
                self._linear, self._coordinates, bounds, step, self._longest_step, self._damping
            )
        return step / max(1.0, float((np.abs(step) / self._longest_step).max()))

    def _gauss_newton(self, damping: float) -> FloatArray:
        return gauss_newton_step(
            self._linear, self._coordinates, self._lower, self._upper, damping
        )

    def is_done(self, step: FloatArray) -> bool:
        """Tell whether a step is too small to take under the present form of the cost."""
        if not self._objective.is_annealed and self.rejections > _MAX_BLUNT_REJECTIONS:
            return True
        # Damping makes any step small: beside what cannot be simulated that says nothing.
        if self.rejections and self._impossible == self.rejections:
            return False
        if self._patience is not None and self.rejections >= self._patience:
            return True
        if self._linear.gain(step) < _SMALL_GAIN:
            return True
        return bool((np.abs(step) < _NEGLIGIBLE * self._longest_step).all())

    def end_wandering(self) -> bool:
        """Go amid the last points where the steps only wander about; tell whether they do."""
        if self.rejections or not self._objective.is_annealed:
            return False
        self._wandering.add(self._coordinates, self._gauss_newton(0.0))
        middle = self._wandering.middle(self._linear.curvature)
        if middle is None:
            return False
        middle = np.clip(middle, self._lower, self._upper)
        if not np.isfinite(_cost(self._objective, middle)):
            return False
        self._coordinates = middle
        self.number += 1
        self._start_anew()
        return True

    def anneal(self) -> bool:
        """Give the cost its next form; False when it has its last one."""
        if self._objective.is_annealed:
            if not self._objective.refine(self._coordinates):
                return False
        else:
            self._objective.anneal(self._coordinates)
        self._wandering = Wandering()
        self._start_anew()
        return True

    def take(self, step: FloatArray) -> bool:
        """Try a step; tell whether it was accepted."""
        trial = np.clip(self._coordinates + step, self._lower, self._upper)
        cost = _cost(self._objective, trial)
        slack = _ROUGHNESS if self._objective.is_annealed else 0.0
        if not cost < self._linear.cost * (1.0 + slack):
            self.rejections += 1
            self._impossible += not np.isfinite(cost)
            self._damping = max(_FIRST_DAMPING, 8.0 * self._damping)
            return False
        trial = self._lengthened(trial, cost)
        last = trial - self._coordinates, self._linear.negative_gradient
        damping = 0.1 * self._damping if self._damping > 1e-3 else 0.0
        self._coordinates = trial
        self.number += 1
        # A boxed step that was stopped has not arrived: the cost stays wide to see the way on.
        if not self._is_boxed or (np.abs(step) < _STOPPED * self._longest_step).all():
            self._objective.anneal(trial)
        self._start_anew()
        self._last, self._damping = last, damping
        return True

    def _lengthened(self, trial: FloatArray, cost: float) -> FloatArray:
        """Double a good step while that pays."""
        for _ in range(self._max_doublings):
            further = np.clip(2.0 * trial - self._coordinates, self._lower, self._upper)
            further_cost = _cost(self._objective, further)
            if not further_cost < cost:
                break
            trial, cost = further, further_cost
        return trial

    def _start_anew(self) -> None:
        self._linear = self._objective.linearise(self._coordinates)
        self.rejections, self._impossible, self._damping, self._last = 0, 0, 0.0, None


def _secant_fraction(
    linear: Linearisation,
    step: FloatArray,
    last_step: FloatArray,
    last_negative_gradient: FloatArray,
) -> float:
    """Return how much of a step to take when it turns back on the last one.

    In the tails of a robust cost the curvature changes from step to step and Gauss-Newton
    oscillates. Where the slope along the last step has changed its sign, the secant tells how far
    back its zero lies.
    """
    before, now = (
        float(last_negative_gradient @ last_step),
        float(linear.negative_gradient @ last_step),
    )
    if before <= 0.0 or now >= 0.0:
        return 1.0
    back = -float(step @ linear.curvature @ last_step)
    length = float(last_step @ linear.curvature @ last_step)
    if back <= 0.0 or length <= 0.0:
        return 1.0
    return min(1.0, -now / (before - now) * length / back)


def _cost(objective: Objective, coordinates: FloatArray) -> float:
    """Return the cost, infinite where the model cannot follow."""
    try:
        cost = objective.cost(coordinates)
    except NotSimulatedError:
        return float('inf')
    return cost if np.isfinite(cost) else float('inf')
