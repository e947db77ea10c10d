# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The linear system of an implicit step: one factorisation, held as long as it serves."""

from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.sparse_solver import make_solver, NotPositiveDefiniteError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# The skew part of damping is a thousandth of the matrix: a round or two settle it.
_SKEW_TOLERANCE = 1e-7
_MAX_SKEW_ROUNDS = 30


class StepSystem:
    """Solves with d (M A' + f) / d x' of a step on the free nodes."""

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics = dynamics
        self._free = dynamics.free
        self._solver = make_solver(dynamics.pattern, dynamics.body.solver.solver_name)
        self._step: float | None = None

    def forget(self) -> None:
        """Let go of the factorisation: the inputs have changed."""
        self._step = None

    def is_ready(self, rule: StepRule) -> bool:
        """Tell whether there is a factorisation for steps of this size."""
        return self._step == rule.step

    def factor(self, rule: StepRule, state: StepState) -> None:
        """Factor the symmetric part of the matrix at a state.

        Raises:
            NotPositiveDefiniteError: when the step is too long for the state.
        """
        self._step = None
        self._solver.factor(
            self._dynamics.system_values(
                state.positions, state.velocities, rule.inertia, rule.rate
            )
        )
        self._step = rule.step

    def apply(self, forces: FloatArray) -> FloatArray:
        """Solve with the factorisation as it is; shape (N, 3), zero on held nodes."""
        solution = np.zeros_like(forces)
        solution[self._free] = self._solver.solve(forces[self._free].ravel()).reshape(-1, 3)
        return solution

    def solve(
        self, state: StepState, right_sides: FloatArray, *, is_transposed: bool
    ) -> FloatArray:
        """Solve exactly at the state factored last, shape (k, N, 3)."""
        solution = self._solve_sides(right_sides)
        elements = self._dynamics.elements
        if not elements.is_damped:
            return solution
        sign = 1.0 if is_transposed else -1.0
        first, rest = solution, solution
        for _ in range(_MAX_SKEW_ROUNDS):
            skew = np.stack(
                [elements.skew_product(state.positions, state.velocities, side) for side in rest]
            )
            rest = sign * self._solve_sides(skew)
            solution = solution + rest
            if np.abs(rest).max() <= _SKEW_TOLERANCE * np.abs(first).max():
                return solution
        raise MotionError(
            'damping outweighs inertia and stiffness in a step: lower the strain-rate damping or '
            'the time step'
        )

    def _solve_sides(self, right_sides: FloatArray) -> FloatArray:
        solution = np.zeros_like(right_sides)
        sides = right_sides[:, self._free].reshape(len(right_sides), -1)
        if len(sides) == 1:
            found = self._solver.solve(sides[0])[None]
        else:
            found = self._solver.solve(np.ascontiguousarray(sides.T)).T
        solution[:, self._free] = found.reshape(len(sides), -1, 3)
        return solution


def factor_at(system: StepSystem, rule: StepRule, state: StepState) -> None:
    """Factor at a state that a march went through.

    Raises:
        MotionError: when the matrix is indefinite there.
    """
    try:
        system.factor(rule, state)
    except NotPositiveDefiniteError as error:
        raise MotionError(
            'a step passes a state of unstable equilibrium, where it has no derivative: lower '
            'the time step'
        ) from error
