# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Turns that may take a rigid part to itself, or nearly: what an image may not tell apart."""

from collections.abc import Callable
from itertools import permutations, product

from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.model import Fixture
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Turns about an axis of revolution [degrees], none of them a common part of a whole turn.
_TRIED = (7.0, 17.0, 31.0, 53.0, 97.0)
# The image agrees as well after such a turn if it loses no more.
_AS_WELL = 0.03


class PartAxes:
    """Principal axes of a surface.

    Attributes:
        middle: of its area, object frame [m], shape (3,).
        axes: unit, right-handed, in columns, shape (3, 3).
    """

    def __init__(self, fixture: Fixture) -> None:
        """Find them."""
        corners = fixture.positions[fixture.triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = 0.5 * np.linalg.norm(across, axis=1)
        self.middle: FloatArray = areas @ corners.mean(axis=1) / areas.sum()
        # The second moment of a triangle, from its corners and its middle (exact for quadratics).
        points = np.concatenate([corners, 3.0 * corners.mean(axis=1, keepdims=True)], axis=1)
        points = points - np.array([1.0, 1.0, 1.0, 3.0])[:, None] * self.middle
        moment = np.einsum('t,tpi,tpj->ij', areas / 12.0, points, points)
        _, axes = np.linalg.eigh(moment)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        self.axes: FloatArray = axes

    def turned(self, pose: FloatArray, axis: FloatArray, angle: float) -> FloatArray:
        """Return a pose of the part turned first about an axis of its own through its middle.

        Args:
            pose: depth_from_object, shape (4, 4).
            axis: unit, object frame, shape (3,).
            angle: [rad].
        """
        return pose @ _about(self.middle, rotation_matrix(angle * axis))

    def near_symmetric(self, pose: FloatArray, fixture: Fixture) -> list[FloatArray]:
        """Return the pose after each turn that takes a cube along the axes to itself, 23 others.

        The middle of the part's box along those axes stays where it is.
        """
        along = fixture.positions @ self.axes
        middle = self.axes @ (0.5 * (along.min(axis=0) + along.max(axis=0)))
        turns = [self.axes @ own @ self.axes.T for own in _cube_turns()]
        return [pose @ _about(middle, own) for own in turns]

    def free_axes(self, pose: FloatArray, merit_of: Callable[[FloatArray], float]) -> FloatArray:
        """Return the axes about which the part may turn and the image agrees as well, (n, 3).

        Args:
            pose: depth_from_object, shape (4, 4).
            merit_of: how well the image agrees with a pose.
        """
        least = merit_of(pose) - _AS_WELL
        found = [
            axis
            for axis in self.axes.T
            if all(
                merit_of(self.turned(pose, axis, np.deg2rad(angle))) >= least for angle in _TRIED
            )
        ]
        return np.array(found).reshape(-1, 3)


def _about(point: FloatArray, turn: FloatArray) -> FloatArray:
    return transform(turn, point - turn @ point)


def _cube_turns() -> list[FloatArray]:
    """Return the rotations that take a cube to itself, but for none at all."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.zeros((3, 3))
            turn[np.arange(3), order] = signs
            if np.linalg.det(turn) > 0.0 and not np.array_equal(turn, np.eye(3)):
                found.append(turn)
    return found
