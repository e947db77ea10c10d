# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body at rest before its release, held by the clamp and a support, and its derivatives."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.fem.giving_clamp import GivingClamp
from diffcal_ros.fem.held_part import HeldPath
from diffcal_ros.fem.motion.dynamics import change_at
from diffcal_ros.fem.motion.inputs import MotionInputs, Release
from diffcal_ros.fem.statics.clamp_way import find_way
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import NO_CONDITIONS
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What a clamp may be off by [m, rad].
_CLAMP_TOLERANCE = 1e-9


class Start:
    """Static equilibrium with the support still there."""

    def __init__(self, body: StaticBody, release: Release | None) -> None:
        """Prepare the supported body.

        Args:
            body: with its clamp alone.
            release: which support there is; None or an empty one: the clamp alone.
        """
        self._clamped = body.held_vertices
        self._supported = np.zeros(0, dtype=np.int32)
        self._support_positions = np.zeros((0, 3))
        if release is not None:
            self._supported = np.asarray(release.supported_vertices, dtype=np.int32)
            positions = release.support_positions
            if positions is None:
                positions = body.mesh.rest_positions[self._supported]
            self._support_positions = np.asarray(positions, dtype=np.float64) - body.origin
        if len(self._support_positions) != len(self._supported):
            raise ValueError(
                f'{len(self._support_positions)} support positions are given for '
                f'{len(self._supported)} supported vertices: give one for each'
            )
        self.static = self._body = body
        if len(self._supported) > 0:
            self.static = StaticBody(
                body.mesh,
                body.discretisation.element,
                np.union1d(self._clamped, self._supported),
                law=body.elastic.law,
                solver=body.solver.stiffness.solver_name,
                device=body.elastic.device,
            )
        self._has_moved = False
        self._inputs: MotionInputs | None = None
        self._clamp = GivingClamp.of(body.clamp, body.held_nodes, NO_CONDITIONS)
        self._gave_way = np.zeros(6)
        self._clamp_positions = np.zeros((0, 3))

    def solve_equilibrium(self, inputs: MotionInputs, clamp_positions: FloatArray) -> FloatArray:
        """Return node positions at rest in the body's own frame [m], shape (N, 3).

        Args:
            inputs: of the motion.
            clamp_positions: of the clamped vertices there [m], shape (h, 3).

        Raises:
            EquilibriumError: when no equilibrium was found.
        """
        self._inputs, self._clamp_positions = inputs, clamp_positions
        self._clamp = GivingClamp.of(self._body.clamp, self._body.held_nodes, inputs.conditions)
        if not self._clamp.gives_way:
            self._gave_way = np.zeros(6)
            return self._settle()
        return self._settle_with_clamp()

    def _settle(self) -> FloatArray:
        """Return node positions with the clamp where it is [m], shape (N, 3)."""
        inputs = self._current()
        # The clamp's own motion is in its positions: the support does not follow it.
        conditions = replace(
            inputs.conditions, clamp_motion=np.zeros(6), clamp_compliance=np.zeros((6, 6))
        )
        state = self.static.solve_own_equilibrium(
            inputs.material,
            inputs.gravity_at(0.0),
            held_path=self._held_path(self._clamp.place(self._clamp_positions, self._gave_way)),
            conditions=conditions,
        )
        return state.positions

    def _settle_with_clamp(self) -> FloatArray:
        """Move the clamp until that is what the load on it asks for, by Newton's method."""
        begin = np.zeros(6)
        begin[self._clamp.ways] = self._gave_way[self._clamp.ways]

        def missing_at(gave_way: FloatArray, _: FloatArray | None) -> FloatArray:
            self._gave_way = gave_way
            load = self._clamp.load(self._settle(), self.static.own_state.reactions)
            return self._clamp.missing(load, gave_way)

        find_way(
            begin, missing_at, lambda: self._clamp.response(*self._way_fields()), _CLAMP_TOLERANCE
        )
        return self.static.own_state.positions

    def _way_fields(self) -> tuple[FloatArray, FloatArray]:
        """Return how the body follows each way, shape (w, N, 3), and the load on the clamp."""
        clamp, positions = self._clamp, self.static.own_state.positions
        held = np.zeros((len(clamp.ways), *positions.shape))
        held[:, clamp.nodes] = self._moves()[clamp.ways]
        fields = self._fields(np.zeros_like(held), held)
        return fields, self._load_changes(fields, np.zeros_like(held))

    def _moves(self) -> FloatArray:
        """Return how held nodes follow the six numbers of what the clamp gives way by."""
        rigid = self._body.held.spread(self._clamp_positions)
        return self._clamp.moves(rigid, self._gave_way)

    def _fields(self, forces: FloatArray, held: FloatArray) -> FloatArray:
        """Return how the body follows loads less forces [N], and held nodes [m], (k, N, 3)."""
        static, forces = self.static, forces.copy()
        positions = static.own_state.positions
        for force, field in zip(forces, held, strict=True):
            if field.any():
                force -= static.solver.stiffness.force_tangent(positions, field)
        return static.solver.stiffness.linear_solve(positions, forces) + held

    def _load_changes(self, fields: FloatArray, explicit: FloatArray) -> FloatArray:
        """Return how the load on the clamp follows; see `StaticDerivatives`, shape (k, w)."""
        state, stiffness = self.static.own_state, self.static.solver.stiffness
        changes = np.stack([stiffness.force_tangent(state.positions, own) for own in fields])
        return self._clamp.load_changes(
            state.positions, state.reactions, fields, changes - explicit
        )

    def tangents(self, changes: Sequence[Change], held: FloatArray) -> FloatArray:
        """Return how the body at rest follows changes [m], shape (k, N, 3).

        Args:
            changes: of the inputs.
            held: how clamped nodes follow them with a rigid clamp, zero elsewhere [m], shape
                (k, N, 3).
        """
        static, inputs = self.static, self._current()
        positions, gravity = static.own_state.positions, inputs.gravity_at(0.0)
        forces = np.stack(
            [
                static.force_changes.along(
                    positions, change_at(change, inputs, 0.0), inputs.material, gravity
                )
                for change in changes
            ]
        )
        held = held.copy()
        nodes, effects = self._clamp.nodes, [change.conditions for change in changes]
        load = self._clamp.load(positions, static.own_state.reactions)
        held[:, nodes] = self._clamp.held_changes(
            held[:, nodes], effects, load, self._gave_way, self._moves()
        )
        fields = self._fields(forces, held)
        if not self._clamp.gives_way:
            return fields
        ways, by_way = self._way_fields()
        answers = self._clamp.answers(self._load_changes(fields, forces), by_way)
        return fields + np.einsum('kj,jni->kni', answers, ways)

    def pull_back(self, by_positions: FloatArray) -> tuple[StaticGradient, FloatArray]:
        """Pull a derivative by the positions at rest back to the inputs and to held nodes.

        Args:
            by_positions: [1/m], shape (N, 3).

        Returns:
            The derivative by the inputs, and by positions of held nodes, shape (N, 3), zero on
            free ones.
        """
        static, inputs = self.static, self._current()
        positions = static.own_state.positions
        adjoint = static.solver.stiffness.linear_solve(positions, by_positions[None])[0]
        by_held = np.zeros_like(by_positions)
        reaction = by_positions - static.solver.stiffness.force_tangent(positions, adjoint)
        by_held[static.held_nodes] = reaction[static.held_nodes]
        gradient = static.force_changes.pull_back(
            positions, adjoint, inputs.material, inputs.gravity_at(0.0)
        )
        return gradient, by_held

    def _current(self) -> MotionInputs:
        if self._inputs is None:
            raise RuntimeError('no motion yet: call simulate first')
        return self._inputs

    def _held_path(self, clamp_positions: FloatArray) -> HeldPath | None:
        """Return the straight way of held vertices from rest; None: they never left it."""
        rest = self.static.own_mesh.rest_positions
        target = rest.copy()
        target[self._clamped] = clamp_positions
        target[self._supported] = self._support_positions
        held = self.static.held_vertices
        first, last = rest[held], target[held]
        self._has_moved = self._has_moved or not np.array_equal(first, last)
        if not self._has_moved:
            return None
        return lambda fraction: (1.0 - fraction) * first + fraction * last
