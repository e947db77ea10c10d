# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tangents and the discrete adjoint of an implicit march, from its stored states alone.

A step solves M A' + f(x', v') = 0 for x'; v', a' and A' follow linearly (`generalised_alpha`).
With J = dA'/dx' M + df/dx + dv'/dx' df/dv, tangents solve with J forward in time and the adjoint
with J^T backward.
"""

from collections.abc import Sequence

from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.frame_reader import FrameReader
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.gradient_sum import GradientSum
from diffcal_ros.fem.motion.held_nodes import HeldState
from diffcal_ros.fem.motion.integrator import ByHeld, HeldChanges
from diffcal_ros.fem.motion.step_system import factor_at, StepSystem
from diffcal_ros.fem.motion.trajectory import Trajectory
from diffcal_ros.fem.statics.force_changes import Change
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class ImplicitDerivatives:
    """Derivatives of one march."""

    def __init__(
        self, dynamics: Dynamics, system: StepSystem, rho_inf: float, trajectory: Trajectory
    ) -> None:
        self._dynamics = dynamics
        self._system = system
        self._rho_inf = rho_inf
        self._trajectory = trajectory

    def _state(self, index: int) -> StepState:
        """Return a stored state; its accelerations follow from the equation of motion."""
        positions = self._trajectory.positions[index]
        velocities = self._trajectory.velocities[index]
        self._dynamics.go_to(self._trajectory.times[index])
        accelerations = self._dynamics.accelerations(positions, velocities)
        return StepState(positions, velocities, accelerations, accelerations)

    def _rule(self, index: int) -> StepRule:
        return self._trajectory.rule(index, self._rho_inf)

    def tangents(
        self,
        changes: Sequence[Change],
        begin: FloatArray,
        held_changes: HeldChanges,
        reader: FrameReader,
    ) -> None:
        """March tangents and let the reader collect frames of shape (k, N, 3).

        Args:
            changes: of the inputs.
            begin: how the start follows them [m], shape (k, N, 3).
            held_changes: of the clamp.
            reader: gets every state.
        """
        tangent = self._first_tangent(changes, begin, held_changes(0.0))
        reader.begin(begin.shape)
        reader.add(0, tangent.positions, tangent.velocities)
        for index in range(1, len(self._trajectory.times)):
            held = held_changes(self._trajectory.times[index])
            tangent = self._next_tangent(index, changes, tangent, held)
            reader.add(index, tangent.positions, tangent.velocities)

    def _first_tangent(
        self, changes: Sequence[Change], begin: FloatArray, held: Sequence[HeldState | None]
    ) -> StepState:
        dynamics, state = self._dynamics, self._state(0)
        velocities = np.zeros_like(begin)
        self._hold(begin, velocities, held)
        forces = np.stack(
            [
                self._residual_change(state, change)
                + dynamics.force_tangent(state.positions, state.velocities, moved, sped)
                for change, moved, sped in zip(changes, begin, velocities, strict=True)
            ]
        )
        accelerations = np.zeros_like(begin)
        accelerations[:, dynamics.free] = (
            -forces[:, dynamics.free] / dynamics.masses[dynamics.free]
        )
        return StepState(begin, velocities, accelerations, accelerations)

    def _next_tangent(
        self,
        index: int,
        changes: Sequence[Change],
        begin: StepState,
        held: Sequence[HeldState | None],
    ) -> StepState:
        dynamics, rule, state = self._dynamics, self._rule(index), self._state(index)
        factor_at(self._system, rule, state, len(changes))
        known = rule.known(begin)
        fixed, sped = np.zeros_like(begin.positions), known.velocities.copy()
        sped[:, dynamics.body.held_nodes] = 0.0
        self._hold(fixed, sped, held)
        forces = dynamics.masses * known.accelerations
        for number, change in enumerate(changes):
            forces[number] += self._residual_change(state, change)
        forces += self._pulled(state, fixed, sped)
        moved = fixed - self._system.solve(state, forces, is_transposed=False)
        end = rule.end(known, moved)
        for part in (end.velocities, end.filtered, end.accelerations):
            part[:, dynamics.body.held_nodes] = 0.0
        self._hold(end.positions, end.velocities, held)
        return end

    def _pulled(self, state: StepState, moved: FloatArray, sped: FloatArray) -> FloatArray:
        """Return how forces follow held nodes and what velocities are known of, (k, N, 3)."""
        dynamics, place = self._dynamics, (state.positions, state.velocities)
        forces = dynamics.velocity_tangents(*place, sped)
        still = np.zeros_like(state.positions)
        for force, own in zip(forces, moved, strict=True):
            if own.any():
                force += dynamics.force_tangent(*place, own, still)
        return forces

    def _residual_change(self, state: StepState, change: Change) -> FloatArray:
        return self._dynamics.residual_change(
            state.positions, state.velocities, state.accelerations, change
        )

    def _hold(
        self, positions: FloatArray, velocities: FloatArray, held: Sequence[HeldState | None]
    ) -> None:
        nodes = self._dynamics.body.held_nodes
        for number, state in enumerate(held):
            if state is not None:
                positions[number, nodes] = state.positions
                velocities[number, nodes] = state.velocities

    def gradient(
        self, by_frames: FloatArray, reader: FrameReader, by_held: ByHeld | None
    ) -> tuple[GradientSum, FloatArray]:
        """March the adjoint back to the start.

        Args:
            by_frames: derivative of a scalar by the frames [1/m], shape (F, N, 3).
            reader: which states the frames were read from.
            by_held: takes the derivative by held nodes; None: nobody asks.

        Returns:
            Sums for the gradient by the inputs, and the derivative by the positions at the
            start, shape (N, 3).
        """
        total = GradientSum(self._dynamics)
        zero = np.zeros_like(self._trajectory.positions[0])
        adjoint = StepState(zero.copy(), zero.copy(), zero.copy(), zero.copy())
        for index in range(len(self._trajectory.times) - 1, 0, -1):
            reader.add_adjoints(index, by_frames, adjoint.positions, adjoint.velocities)
            adjoint = self._adjoint_of_begin(index, adjoint, total, by_held)
        reader.add_adjoints(0, by_frames, adjoint.positions, adjoint.velocities)
        return total, self._adjoint_of_start(adjoint, total, by_held)

    def _adjoint_of_begin(
        self, index: int, after: StepState, total: GradientSum, by_held: ByHeld | None
    ) -> StepState:
        """Return the derivative by a step's begin from that by its end."""
        dynamics, rule, state = self._dynamics, self._rule(index), self._state(index)
        held = dynamics.body.held_nodes
        held_side = after.positions[held].copy(), after.velocities[held].copy()
        for part in (after.positions, after.velocities):
            part[held] = 0.0
        factor_at(self._system, rule, state, 1)
        side = after.positions + rule.rate * after.velocities + rule.pull * after.filtered
        side += rule.inertia * after.accelerations
        adjoint = self._system.solve(state, side[None], is_transposed=True)[0]
        by_positions, by_velocities = dynamics.pull_back(
            state.positions, state.velocities, adjoint, has_positions=by_held is not None
        )
        total.add(state.positions, state.velocities, state.accelerations, adjoint)
        if by_held is not None:
            by_held(
                self._trajectory.times[index],
                held_side[0] - by_positions[held],
                held_side[1] - by_velocities[held],
            )
        by_velocities[held] = 0.0
        return rule.pull_back(
            StepState(
                after.positions,
                after.velocities - by_velocities,
                after.filtered,
                after.accelerations - dynamics.masses * adjoint,
            )
        )

    def _adjoint_of_start(
        self, adjoint: StepState, total: GradientSum, by_held: ByHeld | None
    ) -> FloatArray:
        """Return the derivative by the positions at the start."""
        dynamics, state = self._dynamics, self._state(0)
        held = dynamics.body.held_nodes
        force = (adjoint.filtered + adjoint.accelerations) / dynamics.masses
        force[held] = 0.0
        by_positions, by_velocities = dynamics.pull_back(
            state.positions, state.velocities, force, has_positions=True
        )
        total.add(state.positions, state.velocities, state.accelerations, force)
        start = adjoint.positions - by_positions
        if by_held is not None:
            by_held(
                0.0, np.zeros_like(start[held]), adjoint.velocities[held] - by_velocities[held]
            )
        return start
