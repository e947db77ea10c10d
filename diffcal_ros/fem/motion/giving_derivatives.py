# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tangents of a march whose clamp gives way, or would with one of the changes.

Held nodes follow what the clamp gives way by, dq = dC w + C dw, and the rule of the steps, as all
others do. What the body does with the clamp as it is comes first; then how both answer.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.held_nodes import HeldState
from diffcal_ros.fem.motion.implicit_derivatives import ImplicitDerivatives
from diffcal_ros.fem.motion.step_system import factor_at
from diffcal_ros.fem.statics.force_changes import Change
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def would_give_way(changes: Sequence[Change]) -> bool:
    """Tell whether the clamp gives way with any of some changes."""
    effects = [change.conditions for change in changes]
    return any(own is not None and own.clamp_gives_way for own in effects)


@dataclass(frozen=True)
class _Clamped:
    """The clamp at the end of a step.

    Attributes:
        state: there.
        rule: of the step.
        forces: that its nodes need from elsewhere [N], shape (N, 3).
        load: on it [N, N m], shape (6,).
        gave_way: what it gives way by [m, rad], shape (6,).
        moves: how held nodes follow each number of that, shape (6, h, 3).
        pushes: how each way's load follows forces, shape (w, N, 3).
        by_positions: how it follows positions through them [N/m], shape (w, N, 3).
        by_velocities: how it follows velocities [N s/m], shape (w, N, 3).
    """

    state: StepState
    rule: StepRule
    forces: FloatArray
    load: FloatArray
    gave_way: FloatArray
    moves: FloatArray
    pushes: FloatArray
    by_positions: FloatArray
    by_velocities: FloatArray


class GivingDerivatives(ImplicitDerivatives):
    """Tangents of one march; an adjoint of it there is not."""

    def _first_tangent(
        self, changes: Sequence[Change], begin: FloatArray, held: Sequence[HeldState | None]
    ) -> StepState:
        # The start knows already where held nodes go.
        return super()._first_tangent(changes, begin, [None] * len(held))

    def _next_tangent(
        self,
        index: int,
        changes: Sequence[Change],
        begin: StepState,
        held: Sequence[HeldState | None],
    ) -> StepState:
        dynamics, rule, state = self._dynamics, self._rule(index), self._state(index)
        clamp = dynamics.clamp
        factor_at(self._system, rule, state, len(changes) + len(clamp.ways))
        known, here = rule.known(begin), self._clamped(rule, state)
        explicit = np.stack([self._residual_change(state, change) for change in changes])
        fixed = self._held_changes(here, changes, held)
        moved = self._followed(
            here, fixed, known.velocities, dynamics.masses * known.accelerations + explicit
        )
        if clamp.gives_way:
            sped = known.velocities + rule.rate * moved
            loads = self._load_changes(here, moved, sped, explicit)
            ways, by_way = self._way_fields(here)
            moved += np.einsum('kj,jni->kni', clamp.answers(loads, by_way), ways)
        return rule.end(known, moved)

    def _clamped(self, rule: StepRule, state: StepState) -> _Clamped:
        clamp = self._dynamics.clamp
        forces = self._dynamics.forces(state.positions, state.velocities)
        load = clamp.load(state.positions, forces)
        gave_way = clamp.compliance @ load
        moves = clamp.moves(clamp.unplaced(state.positions[clamp.nodes], gave_way), gave_way)
        pushes = clamp.pushes(state.positions)
        # A way's load is one number: its slope takes one pass, however many changes there are.
        slopes = [
            self._dynamics.pull_back(state.positions, state.velocities, own, has_positions=True)
            for own in pushes
        ]
        pulled = np.array(slopes).reshape(len(pushes), 2, *state.positions.shape)
        return _Clamped(
            state, rule, forces, load, gave_way, moves, pushes, pulled[:, 0], pulled[:, 1]
        )

    def _held_changes(
        self, here: _Clamped, changes: Sequence[Change], held: Sequence[HeldState | None]
    ) -> FloatArray:
        """Return how held nodes follow changes under the load as it is [m], shape (k, N, 3)."""
        clamp = self._dynamics.clamp
        fixed = np.zeros((len(changes), *here.state.positions.shape))
        for field, own in zip(fixed, held, strict=True):
            if own is not None:
                field[clamp.nodes] = own.positions
        effects = [change.conditions for change in changes]
        fixed[:, clamp.nodes] = clamp.held_changes(
            fixed[:, clamp.nodes], effects, here.load, here.gave_way, here.moves
        )
        return fixed

    def _followed(
        self, here: _Clamped, fixed: FloatArray, known: FloatArray, forces: FloatArray
    ) -> FloatArray:
        """Return how the body follows with held nodes as told [m], shape (k, N, 3).

        Args:
            here: the clamp.
            fixed: changes of held nodes [m].
            known: changes of velocities where positions do not change [m/s].
            forces: that free nodes feel besides [N].
        """
        pulled = self._pulled(here.state, fixed, known + here.rule.rate * fixed)
        return fixed - self._system.solve(here.state, forces + pulled, is_transposed=False)

    def _way_fields(self, here: _Clamped) -> tuple[FloatArray, FloatArray]:
        """Return how the body follows each way [m or m/rad], (w, N, 3), and how the load does."""
        clamp = self._dynamics.clamp
        fixed = np.zeros((len(clamp.ways), *here.state.positions.shape))
        fixed[:, clamp.nodes] = here.moves[clamp.ways]
        nothing = np.zeros_like(fixed)
        fields = self._followed(here, fixed, nothing, nothing)
        return fields, self._load_changes(here, fields, here.rule.rate * fields, nothing)

    def _load_changes(
        self, here: _Clamped, moved: FloatArray, sped: FloatArray, explicit: FloatArray
    ) -> FloatArray:
        """Return how the load on the clamp follows, shape (k, w).

        Args:
            here: the clamp.
            moved: changes of positions [m], shape (k, N, 3).
            sped: changes of velocities [m/s], shape (k, N, 3).
            explicit: changes of forces in a fixed state [N], shape (k, N, 3).
        """
        changes = (
            np.einsum('kni,wni->kw', moved, here.by_positions)
            + np.einsum('kni,wni->kw', sped, here.by_velocities)
            + np.einsum('kni,wni->kw', explicit, here.pushes)
        )
        return np.asarray(changes + self._dynamics.clamp.turned_loads(here.forces, moved))
