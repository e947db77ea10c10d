# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a body at rest follows its inputs, forward and back.

With K the stiffness, e the change of loads less forces at fixed positions and h that of held
nodes, the body moves by

    u = K^-1 (e - K h) + h        on the free nodes, h on the held ones.

A clamp that gives way moves by its compliances C, a diagonal matrix, times the force and moment w
on it, which are linear in u and e. With t the fields that follow a unit of each of its motions q
that has a compliance, the whole move is

    u + t A w(u, e),    A = (1 - C dw/dq)^-1 C.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.fem.clamp import Clamp, ClampResponse
from diffcal_ros.fem.statics.applied_conditions import AppliedConditions
from diffcal_ros.fem.statics.equilibrium import Equilibrium
from diffcal_ros.fem.statics.force_changes import Change, ForceChanges, StaticGradient
from diffcal_ros.fem.statics.tangent_stiffness import TangentStiffness
from diffcal_ros.fem.terms.conditions import Conditions
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
        if not self._ways:
            return fields
        ways = self._way_fields()
        response = self._wrench_changes(fields, explicit) @ self._answers(ways).T
        return fields + np.einsum('kj,jni->kni', response, ways)

    def gradient(self, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by node positions [1/m], shape (N, 3), back to the inputs.

        Its `by_effects` holds while the body is in this equilibrium.
        """
        positions, held = self.state.positions, self.held_nodes
        by_explicit = np.zeros_like(by_positions)
        if self._ways:
            ways = self._way_fields()
            by_wrench = self._answers(ways).T @ np.einsum('jni,ni->j', ways, by_positions)
            by_positions, by_explicit = self._through_wrench(by_positions, by_wrench)
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
    def _ways(self) -> list[int]:
        """Which numbers of the clamp's motion follow its load."""
        return self.conditions.now.clamp_ways

    def _held_change(self, effects: Conditions | None) -> FloatArray | None:
        """Return how held nodes move with a change [m], shape (h, 3)."""
        if effects is None or not effects.moves_clamp:
            return None
        nominal, motion = self.held_targets, self.conditions.now.clamp_motion
        moves = self.clamp.change(nominal, motion, effects.clamp_motion)
        if effects.clamp_gives_way:
            positions, reactions = self.state.positions, self.state.reactions
            wrench = self.clamp.wrench(positions[self.held_nodes], -reactions[self.held_nodes])
            way = effects.clamp_compliance @ wrench
            for axis in np.flatnonzero(way):
                moves += way[axis] * self.clamp.way_change(nominal, motion, int(axis))
        return moves

    def _way_fields(self) -> FloatArray:
        """Return how the body follows the clamp where it gives way [m or m/rad], (w, N, 3)."""
        positions, motion = self.state.positions, self.conditions.now.clamp_motion
        held = np.zeros((len(self._ways), *positions.shape))
        for field, axis in zip(held, self._ways, strict=True):
            field[self.held_nodes] = self.clamp.way_change(self.held_targets, motion, axis)
        forces = np.stack([-self.stiffness.force_tangent(positions, field) for field in held])
        return self.stiffness.linear_solve(positions, forces) + held

    def clamp_response(self) -> ClampResponse:
        """Return how clamp and body follow what the clamp should give way by besides."""
        ways = self._way_fields()
        return ClampResponse(self._ways, self._off_by_way(ways), ways)

    def _off_by_way(self, ways: FloatArray) -> FloatArray:
        """Return how what the clamp does is less than what it should do, by way, (w, w)."""
        by_way = self._wrench_changes(ways, np.zeros_like(ways)).T
        return np.eye(len(ways)) - self._per_load @ by_way

    def _answers(self, ways: FloatArray) -> FloatArray:
        """Return how the clamp follows the load that a change adds, A above, (w, w)."""
        return np.asarray(np.linalg.solve(self._off_by_way(ways), self._per_load))

    @property
    def _per_load(self) -> FloatArray:
        return self.conditions.now.clamp_compliance[np.ix_(self._ways, self._ways)]

    def _wrench_changes(self, fields: FloatArray, explicit: FloatArray) -> FloatArray:
        """Return how the load on the clamp follows displacements [N, N m], shape (k, w).

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
            moments = -np.cross(arms, moved) - np.cross(field[held], reactions)
            changes.append(np.concatenate([-moved.sum(axis=0), moments.sum(axis=0)]))
        return np.stack(changes)[:, self._ways]

    def _through_wrench(
        self, by_positions: FloatArray, by_wrench: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Pull a derivative by the load on the clamp back: `_wrench_changes` transposed.

        Args:
            by_positions: derivative by positions that there is besides [1/m], shape (N, 3).
            by_wrench: [1/N, 1/(N m)], shape (w,).

        Returns:
            The derivative by positions, and by loads less forces at fixed positions [1/N],
            shape (N, 3) each.
        """
        positions, held = self.state.positions, self.held_nodes
        whole = np.zeros(6)
        whole[self._ways] = by_wrench
        by_force, by_moment = whole[:3], whole[3:]
        lever = np.zeros_like(by_positions)
        lever[held] = -by_force - np.cross(by_moment, positions[held] - self.clamp.center)
        total = by_positions + self.stiffness.force_tangent(positions, lever)
        total[held] -= np.cross(self.state.reactions[held], by_moment)
        return total, -lever
