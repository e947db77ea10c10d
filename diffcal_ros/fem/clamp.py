# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamp that sits elsewhere than it should, or gives way: rigid motions of held nodes."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.rigid_motion import moved, moved_by
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# In one step a clamp turns by no more than this [rad].
_LONGEST_TURN = 0.3


class Clamp:
    """Moves held nodes; turns go about the middle of the held part."""

    def __init__(self, rest: FloatArray) -> None:
        """Prepare the clamp of nodes at rest [m], shape (h, 3)."""
        self.center = 0.5 * (rest.min(axis=0) + rest.max(axis=0))
        self.gave_way = np.zeros(6)  # Under its load: shift [m] and turn [rad].

    def give_way_by(self, ways: Sequence[int]) -> None:
        """Let some numbers of its motion follow its load; all others are none from now on."""
        stays = np.zeros(6)
        stays[list(ways)] = self.gave_way[list(ways)]
        self.gave_way = stays

    def place(self, positions: FloatArray, motion: FloatArray) -> FloatArray:
        """Return where nodes are held.

        Args:
            positions: where they should be held [m], shape (h, 3).
            motion: of the clamp: shift [m] and turn [rad], shape (6,).
        """
        there = moved(positions, motion, self.center)
        return moved(there, self.gave_way, self.center)

    def change(
        self, positions: FloatArray, motion: FloatArray, direction: FloatArray
    ) -> FloatArray:
        """Return how `place` follows the motion along a direction, shape (h, 3)."""
        total = np.zeros_like(positions)
        for axis in np.flatnonzero(direction):
            total += direction[axis] * moved_by(positions, motion, self.center, int(axis))
        return total @ rotation_matrix(self.gave_way[3:]).T

    def way_change(self, positions: FloatArray, motion: FloatArray, axis: int) -> FloatArray:
        """Return how `place` follows one number of what the clamp gave way by, shape (h, 3)."""
        there = moved(positions, motion, self.center)
        return moved_by(there, self.gave_way, self.center, axis)

    def follow(
        self, positions: FloatArray, motion: FloatArray, wanted: FloatArray, ways: Sequence[int]
    ) -> None:
        """Give way so that held nodes are nearest to where they are expected.

        Args:
            positions: where they should be held [m], shape (h, 3).
            motion: of the clamp, shape (6,).
            wanted: where they are expected [m], shape (h, 3).
            ways: numbers of its motion that follow its load; no other ones change.
        """
        off = (wanted - self.place(positions, motion)).ravel()
        changes = [self.way_change(positions, motion, axis).ravel() for axis in ways]
        step, *_ = np.linalg.lstsq(np.stack(changes, axis=1), off, rcond=None)
        self.gave_way = np.array(self.gave_way)
        self.gave_way[list(ways)] += step

    def wrench(self, positions: FloatArray, forces: FloatArray) -> FloatArray:
        """Return forces on the clamp [N] and their moment about its middle [N m], shape (6,)."""
        moments = np.cross(positions - self.center, forces)
        return np.concatenate([forces.sum(axis=0), moments.sum(axis=0)])


@dataclass(frozen=True)
class ClampResponse:
    """How a clamp gives way, to first order.

    Attributes:
        ways: which numbers of its motion follow its load, w of them.
        off_by_way: how what it does less what it should do grows with each, shape (w, w).
        fields: how the body follows each [m or m/rad], shape (w, N, 3).
    """

    ways: list[int]
    off_by_way: FloatArray
    fields: FloatArray

    def step(self, missing: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return Newton's step, shortened where it would turn the clamp far.

        Args:
            missing: what the clamp should give way by, less what it does [m, rad], shape (6,).

        Returns:
            How much farther it gives way [m, rad], shape (6,), and how the body follows [m],
            shape (N, 3).
        """
        step = np.zeros(6)
        step[self.ways] = np.linalg.solve(self.off_by_way, missing[self.ways])
        step *= min(1.0, _LONGEST_TURN / max(float(np.linalg.norm(step[3:])), _LONGEST_TURN))
        return step, np.einsum('j,jni->ni', step[self.ways], self.fields)
