# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamp that sits elsewhere than it should, or gives way: rigid motions of held nodes."""

from diffcal_ros.rigid_motion import moved, moved_by
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Clamp:
    """Moves held nodes; turns go about the middle of the held part."""

    def __init__(self, rest: FloatArray) -> None:
        """Prepare the clamp of nodes at rest [m], shape (h, 3)."""
        self.center = 0.5 * (rest.min(axis=0) + rest.max(axis=0))
        self.gave_way = np.zeros(6)  # Under its load: shift [m] and turn [rad].

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

    def wrench(self, positions: FloatArray, forces: FloatArray) -> FloatArray:
        """Return forces on the clamp [N] and their moment about its middle [N m], shape (6,)."""
        moments = np.cross(positions - self.center, forces)
        return np.concatenate([forces.sum(axis=0), moments.sum(axis=0)])
