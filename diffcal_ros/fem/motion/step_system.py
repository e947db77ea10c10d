# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The linear system of an implicit step: one factorisation, held as long as it serves."""

from diffcal_ros.fem.linear_solvers import make_solver, NotPositiveDefiniteError
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.inputs import MotionError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What the matrix leaves out of damping and drag is a thousandth of it: a round or two settle that.
_REST_TOLERANCE = 1e-8
_MAX_REST_ROUNDS = 30


class StepSystem:
    """Solves with d (M A' + f) / d x' of a step on the free nodes."""

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics = dynamics
        self._free = dynamics.free
        self._solver = make_solver(
            dynamics.pattern, dynamics.body.solver.stiffness.solver_name, needs_exact=True
        )
        self._step: float | None = None
        self._rate = 0.0

    def forget(self) -> None:
        """Let go of the factorisation: the inputs have changed."""
        self._step = None

    def is_ready(self, rule: StepRule) -> bool:
        """Tell whether there is a factorisation for steps of this size."""
        return self._step == rule.step

    def factor(self, rule: StepRule, positions: FloatArray) -> None:
        """Factor the symmetric main part of the matrix at positions [m], shape (N, 3).

        Raises:
            NotPositiveDefiniteError: when the step is too long for the state.
        """
        self._step = None
        values = self._dynamics.system_values(positions, rule.inertia, rule.rate)
        self._solver.factor(values)
        self._step, self._rate = rule.step, rule.rate

    def apply(self, forces: FloatArray) -> FloatArray:
        """Solve with the factorisation as it is for forces (3 M,) on free nodes; shape (M, 3)."""
        return self._solver.solve(forces).reshape(-1, 3)

    def solve(
        self, state: StepState, right_sides: FloatArray, *, is_transposed: bool
    ) -> FloatArray:
        """Solve exactly at the state factored last, shape (k, N, 3)."""
        solution = self._solve_sides(right_sides)
        dynamics = self._dynamics
        if not dynamics.has_rest:
            return solution
        place = state.positions, state.velocities
        last, size = solution, float(np.abs(solution).max())
        for _ in range(_MAX_REST_ROUNDS):
            products = [
                dynamics.rest_product(*place, side, self._rate, is_transposed=is_transposed)
                for side in last
            ]
            before = float(np.abs(last).max())
            last = -self._solve_sides(np.stack(products))
            solution = solution + last
            now = float(np.abs(last).max())
            # The next round is smaller than this one by as much as this one than the last.
            if now * now <= _REST_TOLERANCE * size * before:
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
        system.factor(rule, state.positions)
    except NotPositiveDefiniteError as error:
        raise MotionError(
            'a step passes a state of unstable equilibrium, where it has no derivative: lower '
            'the time step'
        ) from error
