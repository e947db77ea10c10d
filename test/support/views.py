# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cameras and bodies in front of them, for tests."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
import numpy as np

from support.beams import beam_mesh

# Not square, fx != fy, optical axis off the middle.
CAMERA = PinholeCamera(160, 112, 190.0, 205.0, 71.3, 60.8)


def bent_beam(turn: float = 4.0) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a beam bent to an arc, so that it hides a part of itself.

    Args:
        turn: angle of the arc [rad].
    """
    mesh = beam_mesh((24, 2, 2), (0.30, 0.03, 0.02))
    x, y, z = mesh.rest_positions.T
    angle = turn * x / 0.30
    radius = 0.30 / turn
    # A helix: the ends overlap in the image at different depths.
    points = np.stack(
        [
            (radius + y) * np.sin(angle),
            (radius + y) * np.cos(angle) - radius,
            z + 0.10 * x / 0.30,
        ],
        axis=-1,
    )
    return points - points.mean(axis=0), mesh.surface_triangles


def tilted_view(points: np.ndarray, distance: float = 0.4) -> np.ndarray:
    """Place points in front of the camera, turned about an axis of no symmetry."""
    rotation = rotation_matrix(np.array([0.5, -0.4, 0.3]))
    return apply(transform(rotation, np.array([0.012, -0.008, distance])), points)
