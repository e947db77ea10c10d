# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One implicit step: its equation solved with an old factorisation, or by Newton's method."""

from dataclasses import dataclass
from functools import cached_property

from diffcal_ros.fem.linear_solvers import NotPositiveDefiniteError
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.held_nodes import HeldState
from diffcal_ros.fem.motion.mixing import Mixing
from diffcal_ros.fem.motion.step_system import StepSystem
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_MAX_NEWTON_STEPS = 20
# A factorisation is held while a round of Newton's method leaves no more than this share of the
# force.
_HELD_CONTRACTION = 0.2
# Rounds with an old factorisation, mixed, take a step to its end in 4 to 10; what takes so many
# more needs a new one. A round that leaves so many times the force has lost its way.
_MAX_HELD_ROUNDS = 20
_LOST = 1e3
# Newton's last round leaves much less than it must, and these do not: they go on to this share of
# the tolerance where derivatives are wanted, whose checks divide positions by small steps, unless
# a round leaves more than this share of what is small enough already.
_BEYOND, _STALLED = 0.01, 0.5


class StepFailedError(Exception):
    """A step did not converge."""


@dataclass(frozen=True)
class ImplicitStep:
    """One step to be taken.

    Attributes:
        dynamics: the equation of motion.
        system: of the step.
        rule: of the step.
        begin: state before it.
        held: nodes at its end.
        tolerance: largest force that may be left on a node [N].
    """

    dynamics: Dynamics
    system: StepSystem
    rule: StepRule
    begin: StepState
    held: HeldState
    tolerance: float

    @cached_property
    def known(self) -> StepState:
        """What the end would be at x' = 0."""
        return self.rule.known(self.begin)

    @cached_property
    def _weights(self) -> FloatArray:
        return self.rule.inertia * self.dynamics.masses

    @cached_property
    def _constant(self) -> FloatArray:
        return self.dynamics.masses * self.known.accelerations

    def unbalanced(self, guess: FloatArray) -> float:
        """Return the largest force that a guess of the end leaves on a free node [N]."""
        guess[self.dynamics.body.held_nodes] = self.held.positions
        return self._unbalanced(guess)[1]

    def take(self, guess: FloatArray) -> StepState:
        """Return the end.

        Args:
            guess: of its positions [m], shape (N, 3).

        Raises:
            StepFailedError: when neither way converges.
        """
        guess[self.dynamics.body.held_nodes] = self.held.positions
        end = self._by_held_factor(guess.copy())
        return self._by_newton(guess) if end is None else end

    def _by_held_factor(self, positions: FloatArray) -> StepState | None:
        """Use an old factorisation, turned with the body; None where it is too old."""
        system, free = self.system, self.dynamics.free
        if system.is_worn or not system.is_ready(self.rule):
            try:
                # Where the step begins forces are in balance: no volume is wrong.
                system.factor(self.rule, self.begin.positions)
            except NotPositiveDefiniteError:
                return None
        system.turn(positions)
        goal = self.tolerance * (_BEYOND if system.has_derivatives else 1.0)
        mixing, before, ratio = Mixing(), np.inf, 1.0
        for count in range(_MAX_HELD_ROUNDS):
            unbalanced, largest = self._unbalanced(positions)
            last, ratio = ratio, largest / before
            if largest < goal or (largest < self.tolerance and ratio > _STALLED):
                system.note(count)
                return self._end(positions)
            if not largest < _LOST * before:
                break
            before = largest
            place, change = positions[free], -system.apply(unbalanced)
            step = mixing.step(place.ravel(), change.ravel()).reshape(-1, 3)
            positions[free] = place + step
            if count > 1 and largest * max(ratio, last) < goal:
                # This round leaves less than the last ones did.
                system.note(count + 1)
                return self._end(positions)
        system.forget()
        return None

    def _by_newton(self, positions: FloatArray) -> StepState:
        """Use new factorisations as often as that serves."""
        system, free = self.system, self.dynamics.free
        before = np.inf
        for count in range(_MAX_NEWTON_STEPS):
            unbalanced, largest = self._unbalanced(positions)
            if largest < self.tolerance:
                return self._end(positions)
            if not np.isfinite(largest):
                break
            ratio, before = largest / before, largest
            if ratio > _HELD_CONTRACTION or not system.is_ready(self.rule):
                try:
                    system.factor(self.rule, positions)
                except NotPositiveDefiniteError:
                    break
                ratio = 1.0
            positions[free] -= system.apply(unbalanced)
            if count > 1 and largest * ratio < self.tolerance:
                # This round leaves less than the last one did.
                return self._end(positions)
        raise StepFailedError

    def _unbalanced(self, positions: FloatArray) -> tuple[FloatArray, float]:
        """Return the force left on free nodes [N], shape (3 M,), and its largest component."""
        dynamics = self.dynamics
        velocities = self.rule.rate * positions
        velocities += self.known.velocities
        velocities[dynamics.body.held_nodes] = self.held.velocities
        force = dynamics.forces(positions, velocities)
        force += self._constant
        force += self._weights * positions
        unbalanced = force[dynamics.free].ravel()
        return unbalanced, float(np.abs(unbalanced).max())

    def _end(self, positions: FloatArray) -> StepState:
        end, nodes = self.rule.end(self.known, positions), self.dynamics.body.held_nodes
        end.velocities[nodes] = self.held.velocities
        end.filtered[nodes] = end.accelerations[nodes] = 0.0
        return end
