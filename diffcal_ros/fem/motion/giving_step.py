# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One implicit step of a body whose clamp gives way under it.

The clamp goes where the load at the end of the step has it, by Newton's method around steps with
held nodes where they are told to be.
"""

from dataclasses import dataclass, replace

from diffcal_ros.fem.clamp import ClampResponse
from diffcal_ros.fem.giving_clamp import GivingClamp
from diffcal_ros.fem.motion.generalised_alpha import StepState
from diffcal_ros.fem.motion.held_nodes import HeldState
from diffcal_ros.fem.motion.implicit_step import ImplicitStep, StepFailedError
from diffcal_ros.fem.motion.mixing import Mixing
from diffcal_ros.fem.statics.clamp_way import SLOW
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What a clamp may be off by [m, rad], so that a body's end is off by no more than its nodes are;
# where derivatives are wanted, by this share of it.
_TOLERANCE, _BEYOND = 1e-8, 0.01
_MAX_ROUNDS = 12


@dataclass
class LastResponse:
    """How the clamp followed in the last steps: it changes little from one to the next."""

    step: float = 0.0
    response: ClampResponse | None = None


@dataclass(frozen=True)
class GivingStep:
    """One step to be taken.

    Attributes:
        step: with held nodes where a rigid clamp has them.
        clamp: that gives way.
        last: what the steps before it found.
    """

    step: ImplicitStep
    clamp: GivingClamp
    last: LastResponse

    def unbalanced(self, guess: FloatArray) -> float:
        """Return the largest force [N] that a guess of the end leaves on a free node."""
        return self._with(self._followed(guess)).unbalanced(guess)

    def take(self, guess: FloatArray) -> StepState:
        """Return the end.

        Args:
            guess: of its positions [m], shape (N, 3).

        Raises:
            StepFailedError: when the step or the clamp does not converge.
        """
        gave_way, before, response = self._followed(guess), np.inf, self._known_response()
        goal = _TOLERANCE * (_BEYOND if self.step.system.has_derivatives else 1.0)
        mixing = Mixing()
        for _ in range(_MAX_ROUNDS):
            end = self._with(gave_way).take(guess)
            forces = self.step.dynamics.forces(end.positions, end.velocities)
            load = self.clamp.load(end.positions, forces)
            missing = self.clamp.missing(load, gave_way)
            left = float(np.abs(missing).max())
            if left < goal:
                return self._ended(end.positions)
            if response is None or left > SLOW * before:
                response = self._response(end, forces, gave_way)
            change = mixing.step(gave_way, response.step(missing)[0])
            guess = end.positions + np.einsum('j,jni->ni', change[response.ways], response.fields)
            if np.isfinite(before) and left * left / before < goal:
                # This round leaves less than the last one did.
                return self._ended(guess)
            gave_way, before = gave_way + change, left
        raise StepFailedError

    def _followed(self, guess: FloatArray) -> FloatArray:
        return self.clamp.followed(self.step.held.positions, guess[self.clamp.nodes])

    def _with(self, gave_way: FloatArray) -> ImplicitStep:
        """Return the step with held nodes where the clamp then has them."""
        positions = self.clamp.place(self.step.held.positions, gave_way)
        known = self.step.known.velocities[self.clamp.nodes]
        held = HeldState(positions, known + self.step.rule.rate * positions)
        return replace(self.step, held=held)

    def _known_response(self) -> ClampResponse | None:
        return self.last.response if self.last.step == self.step.rule.step else None

    def _response(self, end: StepState, forces: FloatArray, gave_way: FloatArray) -> ClampResponse:
        """Return how clamp and body follow what is missing, by the last factorisation."""
        step, clamp = self.step, self.clamp
        fields = np.zeros((len(clamp.ways), *end.positions.shape))
        fields[:, clamp.nodes] = clamp.moves(step.held.positions, gave_way)[clamp.ways]
        dynamics, rate, place = step.dynamics, step.rule.rate, (end.positions, end.velocities)
        for field in fields:
            pulled = dynamics.force_tangent(*place, field, rate * field)
            field[dynamics.free] -= step.system.apply(pulled[dynamics.free].ravel())
        changes = np.stack(
            [dynamics.force_tangent(*place, field, rate * field) for field in fields]
        )
        by_way = clamp.load_changes(end.positions, forces, fields, changes)
        self.last.step, self.last.response = step.rule.step, clamp.response(fields, by_way)
        return self.last.response

    def _ended(self, positions: FloatArray) -> StepState:
        """Return an end whose held nodes go by the rule as all others do."""
        return self.step.rule.end(self.step.known, positions)
