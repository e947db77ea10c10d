# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a body at rest follows its inputs, forward and back.

With K the stiffness, e the change of loads less forces at fixed positions and h that of held
nodes, the body moves by

    u = K^-1 (e - K h) + h        on the free nodes, h on the held ones.

A clamp that gives way turns by its compliance c times the moment m on it, which is linear in u
and e. With t the fields that follow a unit turn about each axis, the whole move is

    u + t A m(u, e),    A = c (1 - c dm/dturn)^-1.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.fem.applied_conditions import AppliedConditions
from diffcal_ros.fem.clamp import Clamp
from diffcal_ros.fem.conditions import Conditions
from diffcal_ros.fem.equilibrium import Equilibrium
from diffcal_ros.fem.force_changes import Change, ForceChanges, StaticGradient
from diffcal_ros.fem.tangent_stiffness import TangentStiffness
from diffcal_ros.material import Material
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class StaticDerivatives:
    """Derivatives at one equilibrium, in the body's own frame.

    Attributes:
        state: the equilibrium.
        stiffness: of the body there.
        force_changes: of the body.
        conditions: effects on it.
        clamp: that holds it.
        held_nodes: shape (h,).
        held_targets: where they should be held, before the clamp's own motion [m], shape (h, 3).
        material: one value per tetrahedron.
        gravity: [m/s^2], shape (3,).
    """

    state: Equilibrium
    stiffness: TangentStiffness
    force_changes: ForceChanges
    conditions: AppliedConditions
    clamp: Clamp
    held_nodes: IntArray
    held_targets: FloatArray
    material: Material
    gravity: FloatArray

    def tangents(self, changes: Sequence[Change]) -> FloatArray:
        """Return the displacement per unit of each change [m], shape (k, N, 3)."""
        positions = self.state.positions
        explicit = np.stack(
            [
                self.force_changes.along(positions, change, self.material, self.gravity)
                for change in changes
            ]
        )
        forces, held = explicit.copy(), np.zeros_like(explicit)
        for number, change in enumerate(changes):
            motion = self._held_change(change.conditions)
            if motion is not None:
                held[number, self.held_nodes] = motion
                forces[number] -= self.stiffness.force_tangent(positions, held[number])
        fields = self.stiffness.linear_solve(positions, forces) + held
        if self._compliance == 0.0:
            return fields
        turns = self._turn_fields()
        response = self._moment_changes(fields, explicit) @ self._answers(turns).T
        return fields + np.einsum('kj,jni->kni', response, turns)

    def gradient(self, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by node positions [1/m], shape (N, 3), back to the inputs.

        Its `by_effects` holds while the body is in this equilibrium.
        """
        positions, held = self.state.positions, self.held_nodes
        by_explicit = np.zeros_like(by_positions)
        if self._compliance != 0.0:
            turns = self._turn_fields()
            by_moment = self._answers(turns).T @ np.einsum('jni,ni->j', turns, by_positions)
            by_positions, by_explicit = self._through_moment(by_positions, by_moment)
        adjoint = self.stiffness.linear_solve(positions, by_positions[None])[0]
        by_held = (by_positions - self.stiffness.force_tangent(positions, adjoint))[held]
        adjoint += by_explicit
        gradient = self.force_changes.pull_back(positions, adjoint, self.material, self.gravity)

        def by_effects(change: Conditions) -> float:
            force = self.conditions.force_change(positions, change, self.gravity)
            motion = self._held_change(change)
            moved = 0.0 if motion is None else float((by_held * motion).sum())
            return float((adjoint * force).sum()) + moved

        return replace(gradient, by_effects=by_effects)

    @property
    def _compliance(self) -> float:
        return self.conditions.now.clamp_compliance

    def _held_change(self, effects: Conditions | None) -> FloatArray | None:
        """Return how held nodes move with a change [m], shape (h, 3)."""
        if effects is None or not effects.moves_clamp:
            return None
        nominal, motion = self.held_targets, self.conditions.now.clamp_motion
        moves = self.clamp.change(nominal, motion, effects.clamp_motion)
        if effects.clamp_compliance != 0.0:
            positions, reactions = self.state.positions, self.state.reactions
            moment = self.clamp.moment(positions[self.held_nodes], -reactions[self.held_nodes])
            turn = effects.clamp_compliance * moment
            for axis in range(3):
                moves += turn[axis] * self.clamp.turn_change(nominal, motion, axis)
        return moves

    def _turn_fields(self) -> FloatArray:
        """Return how the body follows a turn of the clamp about each axis [m], (3, N, 3)."""
        positions, motion = self.state.positions, self.conditions.now.clamp_motion
        held = np.zeros((3, *positions.shape))
        for axis in range(3):
            held[axis, self.held_nodes] = self.clamp.turn_change(self.held_targets, motion, axis)
        forces = np.stack([-self.stiffness.force_tangent(positions, field) for field in held])
        return self.stiffness.linear_solve(positions, forces) + held

    def _answers(self, turns: FloatArray) -> FloatArray:
        """Return how the clamp turns with the moment that a change adds, A above, (3, 3)."""
        by_turn = self._moment_changes(turns, np.zeros_like(turns)).T
        answers: FloatArray = self._compliance * np.linalg.inv(
            np.eye(3) - self._compliance * by_turn
        )
        return answers

    def _moment_changes(self, fields: FloatArray, explicit: FloatArray) -> FloatArray:
        """Return how the moment on the clamp follows displacements [N m], shape (k, 3).

        Args:
            fields: displacements [m], shape (k, N, 3).
            explicit: change of loads less forces at fixed positions [N], shape (k, N, 3).
        """
        positions, held = self.state.positions, self.held_nodes
        reactions = self.state.reactions[held]
        arms = positions[held] - self.clamp.center
        changes = []
        for field, force in zip(fields, explicit, strict=True):
            moved = (self.stiffness.force_tangent(positions, field) - force)[held]
            changes.append(-np.cross(arms, moved) - np.cross(field[held], reactions))
        return np.stack(changes).sum(axis=1)

    def _through_moment(
        self, by_positions: FloatArray, by_moment: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Pull a derivative by the moment on the clamp back: `_moment_changes` transposed.

        Args:
            by_positions: derivative by positions that there is besides [1/m], shape (N, 3).
            by_moment: [1/(N m)], shape (3,).

        Returns:
            The derivative by positions, and by loads less forces at fixed positions [1/N],
            shape (N, 3) each.
        """
        positions, held = self.state.positions, self.held_nodes
        lever = np.zeros_like(by_positions)
        lever[held] = -np.cross(by_moment, positions[held] - self.clamp.center)
        total = by_positions + self.stiffness.force_tangent(positions, lever)
        total[held] -= np.cross(self.state.reactions[held], by_moment)
        return total, -lever
