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
from functools import cached_property

from diffcal_ros.fem.clamp import Clamp, ClampResponse
from diffcal_ros.fem.giving_clamp import GivingClamp
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
        if not self._giving.gives_way:
            return fields
        ways, by_way = self._way_fields()
        answers = self._giving.answers(self._wrench_changes(fields, explicit), by_way)
        return fields + np.einsum('kj,jni->kni', answers, ways)

    def gradient(self, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by node positions [1/m], shape (N, 3), back to the inputs.

        Its `by_effects` holds while the body is in this equilibrium.
        """
        positions, held = self.state.positions, self.held_nodes
        by_explicit = np.zeros_like(by_positions)
        if self._giving.gives_way:
            ways, by_way = self._way_fields()
            by_answer = np.einsum('jni,ni->j', ways, by_positions)
            by_wrench = self._giving.answers(np.eye(len(ways)), by_way) @ by_answer
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

    @cached_property
    def _giving(self) -> GivingClamp:
        return GivingClamp.of(self.clamp, self.held_nodes, self.conditions.now)

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

    def _way_fields(self) -> tuple[FloatArray, FloatArray]:
        """Return how the body follows each way [m or m/rad], (w, N, 3), and how the load does."""
        positions, motion = self.state.positions, self.conditions.now.clamp_motion
        held = np.zeros((len(self._giving.ways), *positions.shape))
        for field, axis in zip(held, self._giving.ways, strict=True):
            field[self.held_nodes] = self.clamp.way_change(self.held_targets, motion, axis)
        forces = np.stack([-self.stiffness.force_tangent(positions, field) for field in held])
        fields = self.stiffness.linear_solve(positions, forces) + held
        return fields, self._wrench_changes(fields, np.zeros_like(fields))

    def clamp_response(self) -> ClampResponse:
        """Return how clamp and body follow what the clamp should give way by besides."""
        return self._giving.response(*self._way_fields())

    def _wrench_changes(self, fields: FloatArray, explicit: FloatArray) -> FloatArray:
        """Return how the load on the clamp follows displacements [N, N m], shape (k, w).

        Args:
            fields: displacements [m], shape (k, N, 3).
            explicit: change of loads less forces at fixed positions [N], shape (k, N, 3).
        """
        positions, reactions = self.state.positions, self.state.reactions
        pulled = [self.stiffness.force_tangent(positions, field) for field in fields]
        return self._giving.load_changes(positions, reactions, fields, np.stack(pulled) - explicit)

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
        whole[self._giving.ways] = by_wrench
        lever = np.einsum('w,wni->ni', by_wrench, self._giving.pushes(positions))
        total = by_positions + self.stiffness.force_tangent(positions, lever)
        total[held] -= np.cross(self.state.reactions[held], whole[3:])
        return total, -lever
