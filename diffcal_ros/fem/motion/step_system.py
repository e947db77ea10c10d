# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The linear system of an implicit step: one factorisation, held as long as it serves.

A step's matrix changes above all because the body turns: inertia does not feel that, and stiffness
turns with the material. So an old factorisation serves with forces turned back, node by node, to
where it was made, and their answer turned forth.
"""

from diffcal_ros.fem.linear_solvers import (
    make_solver,
    NotPositiveDefiniteError,
    SparseSolver,
)
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.motion.node_rotations import NodeRotations
from diffcal_ros.fem.motion.rest_rounds import solve_with_rest
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# From so many unknowns on, so many right sides take less time with a multifrontal factorisation,
# made anew in every step, than with a simplicial one.
_FRONTS_PAY, _MANY = 500, 4
# A factorisation with its matrix takes about as long as so many rounds with an old one.
_WORTH = 12


class StepSystem:
    """Solves with d (M A' + f) / d x' of a step on the free nodes."""

    def __init__(self, dynamics: Dynamics, *, has_derivatives: bool = True) -> None:
        """Prepare the system.

        Args:
            dynamics: the equation of motion.
            has_derivatives: `solve` is asked for; a march alone does with a rougher solver.
        """
        self.has_derivatives = has_derivatives
        self._dynamics = dynamics
        self._free = dynamics.free
        name = dynamics.body.solver.stiffness.solver_name
        self._marching = self._solver = make_solver(
            dynamics.pattern, name, needs_exact=True if has_derivatives else None
        )
        self._deriving: SparseSolver | None = None
        self._step: float | None = None
        self._rate = 0.0
        self._rotations = NodeRotations(dynamics.body.elastic)
        self._factored_at = np.zeros((0, 3))
        self._begun: FloatArray | None = None
        self._turns: FloatArray | None = None
        self._rounds: list[int] = []

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
        self._factor(self._marching, rule, positions)
        self._step = rule.step

    def factor_for(self, count: int, rule: StepRule, positions: FloatArray) -> None:
        """Do that to `solve` for so many right sides; no later step can use it.

        Raises:
            NotPositiveDefiniteError: likewise.
        """
        pattern = self._dynamics.pattern
        solver = self._marching
        if solver.name == 'qdldl' and count >= _MANY and pattern.size >= _FRONTS_PAY:
            if self._deriving is None:
                self._deriving = make_solver(pattern, 'multifrontal', needs_exact=True)
            solver = self._deriving
        self._factor(solver, rule, positions)

    def _factor(self, solver: SparseSolver, rule: StepRule, positions: FloatArray) -> None:
        self._step = None
        values = self._dynamics.system_values(positions, rule.inertia, rule.rate)
        solver.factor(values)
        self._solver, self._rate = solver, rule.rate
        self._factored_at, self._begun, self._turns = positions.copy(), None, None
        self._rounds = []

    def turn(self, positions: FloatArray) -> None:
        """Turn the factorisation with the material to positions [m], shape (N, 3).

        The stiffness of a law that takes a turn for a strain does not turn.
        """
        if not self._dynamics.body.elastic.law.TAKES_TURNING_STEPS:
            return
        if self._begun is None:
            self._begun = self._rotations.at(self._factored_at)[self._free]
        now = self._rotations.at(positions)[self._free]
        self._turns = now @ self._begun.transpose(0, 2, 1)

    def note(self, rounds: int) -> None:
        """Take notice of how many rounds a step took with the factorisation."""
        self._rounds.append(rounds)

    @property
    def is_worn(self) -> bool:
        """Tell whether a new factorisation will pay.

        It does once a step takes more than all have taken on average, the factorisation included.
        """
        count = len(self._rounds)
        return count > 0 and self._rounds[-1] * count > _WORTH + sum(self._rounds)

    def apply(self, forces: FloatArray) -> FloatArray:
        """Solve with the factorisation as it is for forces (3 M,) on free nodes; shape (M, 3)."""
        if self._turns is None:
            return self._solver.solve(forces).reshape(-1, 3)
        back = np.einsum('nji,nj->ni', self._turns, forces.reshape(-1, 3))
        solved = self._solver.solve(back.ravel()).reshape(-1, 3)
        return np.einsum('nij,nj->ni', self._turns, solved)

    def solve(
        self, state: StepState, right_sides: FloatArray, *, is_transposed: bool
    ) -> FloatArray:
        """Solve exactly at the state factored last, shape (k, N, 3)."""
        first = self._solve_sides(right_sides)
        dynamics = self._dynamics
        if not dynamics.has_rest:
            return first
        place = state.positions, state.velocities

        def rest(sides: FloatArray) -> FloatArray:
            left = dynamics.rest_product(*place, sides, self._rate, is_transposed=is_transposed)
            return self._solve_sides(left)

        solution = solve_with_rest(rest, first)
        if solution is None:
            raise MotionError(
                'damping outweighs inertia and stiffness in a step: lower the strain-rate '
                'damping or the time step'
            )
        return solution

    def _solve_sides(self, right_sides: FloatArray) -> FloatArray:
        solution = np.zeros_like(right_sides)
        sides = right_sides[:, self._free].reshape(len(right_sides), -1)
        if len(sides) == 1:
            found = self._solver.solve(sides[0])[None]
        else:
            found = self._solver.solve(np.ascontiguousarray(sides.T)).T
        solution[:, self._free] = found.reshape(len(sides), -1, 3)
        return solution


def factor_at(system: StepSystem, rule: StepRule, state: StepState, count: int) -> None:
    """Factor at a state that a march went through, for so many right sides.

    Raises:
        MotionError: when the matrix is indefinite there.
    """
    try:
        system.factor_for(count, rule, state.positions)
    except NotPositiveDefiniteError as error:
        raise MotionError(
            'a step passes a state of unstable equilibrium, where it has no derivative: lower '
            'the time step'
        ) from error
