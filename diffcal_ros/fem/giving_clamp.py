# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamp that gives way as the load on it has it, at rest and at each time of a swing.

    q = C w(x, v, q)

with what the clamp gives way by, q, its compliance C and the load w on it: force and moment of
what elements, damping and weight leave on held nodes. The clamp has no mass: what little of the
body it holds is not accelerated by as much as the rest is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.fem.clamp import Clamp, ClampResponse
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.rigid_motion import moved, moved_by
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Steps that tell a turn from where it leads, and what the last one may be [m, rad]: each leaves
# about the square of what it was.
_FOLLOWED, _CLOSE = 6, 1e-5


@dataclass(frozen=True)
class GivingClamp:
    """Where held nodes are for what the clamp gives way by, and the load on it.

    Attributes:
        clamp: whose middle it turns about.
        nodes: held by it, shape (h,).
        compliance: shift [m] and turn [rad] per force [N] and moment [N m], shape (6, 6).
        ways: which numbers of its motion follow its load, w of them.
    """

    clamp: Clamp
    nodes: IntArray
    compliance: FloatArray
    ways: list[int]

    @classmethod
    def of(cls, clamp: Clamp, nodes: IntArray, conditions: Conditions) -> 'GivingClamp':
        """Return a clamp that gives way as some conditions say."""
        return cls(clamp, nodes, conditions.clamp_compliance, conditions.clamp_ways)

    @property
    def gives_way(self) -> bool:
        """Tell whether it does: else it is where it is put."""
        return bool(self.ways)

    @property
    def per_load(self) -> FloatArray:
        """Its compliance among its ways, shape (w, w)."""
        return self.compliance[np.ix_(self.ways, self.ways)]

    def place(self, points: FloatArray, gave_way: FloatArray) -> FloatArray:
        """Return where points go [m], shape (h, 3), that would be here with a rigid clamp."""
        return moved(points, gave_way, self.clamp.center)

    def unplaced(self, there: FloatArray, gave_way: FloatArray) -> FloatArray:
        """Return where a rigid clamp has points that go there [m], shape (h, 3)."""
        center = self.clamp.center
        return (there - gave_way[:3] - center) @ rotation_matrix(gave_way[3:]) + center

    def held_changes(
        self,
        rigid: FloatArray,
        changes: Sequence[Conditions | None],
        load: FloatArray,
        gave_way: FloatArray,
        moves: FloatArray,
    ) -> FloatArray:
        """Return how held nodes follow changes under the load as it is [m], shape (k, h, 3).

        Args:
            rigid: how they do with a rigid clamp [m], shape (k, h, 3).
            changes: of the conditions.
            load: on the clamp [N, N m], shape (6,).
            gave_way: what it gives way by [m, rad], shape (6,).
            moves: how held nodes follow each number of that, shape (6, h, 3).
        """
        held = rigid @ rotation_matrix(gave_way[3:]).T
        for field, change in zip(held, changes, strict=True):
            if change is not None and change.clamp_gives_way:
                field += np.einsum('j,jni->ni', change.clamp_compliance @ load, moves)
        return np.asarray(held)

    def moves(self, points: FloatArray, gave_way: FloatArray) -> FloatArray:
        """Return how `place` follows each of the six numbers, shape (6, h, 3)."""
        center = self.clamp.center
        return np.stack([moved_by(points, gave_way, center, axis) for axis in range(6)])

    def followed(self, points: FloatArray, there: FloatArray) -> FloatArray:
        """Return what it gives way by where points are to be elsewhere [m, rad], shape (6,).

        Args:
            points: with a rigid clamp [m], shape (h, 3).
            there: where they are [m], shape (h, 3).
        """
        found, ways = np.zeros(6), self.ways
        for _ in range(_FOLLOWED):
            off = (there - self.place(points, found)).ravel()
            moves = [moved_by(points, found, self.clamp.center, way).ravel() for way in ways]
            step, *_ = np.linalg.lstsq(np.stack(moves, axis=1), off, rcond=None)
            found[ways] += step
            if np.abs(step).max(initial=0.0) < _CLOSE:
                break
        return found

    def load(self, positions: FloatArray, forces: FloatArray) -> FloatArray:
        """Return the load on it [N, N m], shape (6,).

        Args:
            positions: of all nodes [m], shape (N, 3).
            forces: that all nodes need from elsewhere [N], shape (N, 3).
        """
        return self.clamp.wrench(positions[self.nodes], -forces[self.nodes])

    def load_changes(
        self, positions: FloatArray, forces: FloatArray, fields: FloatArray, changes: FloatArray
    ) -> FloatArray:
        """Return how the load follows changes [N, N m], shape (k, w).

        Args:
            positions: of all nodes [m], shape (N, 3).
            forces: see `load`.
            fields: changes of the positions [m], shape (k, N, 3).
            changes: of the forces, those through positions included [N], shape (k, N, 3).
        """
        pushed = np.einsum('kni,wni->kw', changes, self.pushes(positions))
        return np.asarray(pushed + self.turned_loads(forces, fields))

    def pushes(self, positions: FloatArray) -> FloatArray:
        """Return how each way's load follows the forces of `load`, shape (w, N, 3)."""
        pushes = np.zeros((6, *positions.shape))
        arms = positions[self.nodes] - self.clamp.center
        for axis, unit in enumerate(np.eye(3)):
            pushes[axis, self.nodes] = -unit
            pushes[3 + axis, self.nodes] = -np.cross(unit, arms)
        return pushes[self.ways]

    def turned_loads(self, forces: FloatArray, fields: FloatArray) -> FloatArray:
        """Return how the load follows positions under forces that stay, shape (k, w)."""
        moments = -np.cross(fields[:, self.nodes], forces[self.nodes]).sum(axis=1)
        return np.concatenate([np.zeros_like(moments), moments], axis=1)[:, self.ways]

    def missing(self, load: FloatArray, gave_way: FloatArray) -> FloatArray:
        """Return what it should give way by, less what it does [m, rad], shape (6,)."""
        return np.asarray(self.compliance @ load - gave_way)

    def response(self, fields: FloatArray, by_way: FloatArray) -> ClampResponse:
        """Return how it follows what is missing.

        Args:
            fields: how the body follows each way [m or m/rad], shape (w, N, 3).
            by_way: how the load follows each way, shape (w, w).
        """
        return ClampResponse(self.ways, self._off_by_way(by_way), fields)

    def answers(self, changes: FloatArray, by_way: FloatArray) -> FloatArray:
        """Return how it follows changes of the load at fixed ways, shape (k, w).

        Args:
            changes: of the load, shape (k, w).
            by_way: how the load follows each way, shape (w, w).
        """
        missing = self.per_load @ changes.T
        return np.asarray(np.linalg.solve(self._off_by_way(by_way), missing).T)

    def _off_by_way(self, by_way: FloatArray) -> FloatArray:
        """Return how what it does is less than what it should do, by way, shape (w, w)."""
        return np.asarray(np.eye(len(self.ways)) - self.per_load @ by_way.T)
