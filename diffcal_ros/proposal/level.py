# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Clamps are mounted level: a placement that is nearly so is taken to be.

A clamp's tilt and the body's modulus make up for each other, so that an image of one posture
hardly tells them apart. What people build tells more.
"""

from diffcal_ros.rigid_transform import angle_between, rotation_matrix, transform
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A body whose frame is turned from the vertical by no more than this [rad] is meant to be level.
NEARLY_LEVEL = float(np.deg2rad(15.0))


def level_placement(
    world_from_object: FloatArray, direction: FloatArray, gravity: FloatArray, pivot: FloatArray
) -> FloatArray:
    """Turn a body about a point until gravity runs along one of its axes, where it nearly does.

    Args:
        world_from_object: where it is, shape (4, 4).
        direction: unit, along the body, object frame, shape (3,).
        gravity: in the world frame [m/s^2], shape (3,).
        pivot: that point, object frame [m], shape (3,).

    Returns:
        The placement, shape (4, 4); the same where the body is far from level.
    """
    rotation = world_from_object[:3, :3]
    down = rotation.T @ gravity / np.linalg.norm(gravity)
    axes = _axes(direction)
    axis = axes[np.argmax(axes @ down)]
    if float(axis @ down) < np.cos(NEARLY_LEVEL):
        return world_from_object
    across = np.cross(axis, down)
    sine = float(np.linalg.norm(across))
    if sine < 1e-12:
        return world_from_object
    # Onto the axis in the object's frame: `down` of the new rotation is `axis` itself.
    turn = rotation_matrix(across / sine * np.arctan2(sine, float(axis @ down)))
    turned = rotation @ turn
    return transform(turned, world_from_object[:3, 3] + (rotation - turned) @ pivot)


def tilt(world_from_object: FloatArray, level: FloatArray) -> float:
    """Return by how much a placement was turned to be level [rad]."""
    return angle_between(world_from_object, level)


def _axes(direction: FloatArray) -> FloatArray:
    """Return the axes both ways, shape (6, 3): along the body, and two across it."""
    across = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    across /= np.linalg.norm(across)
    half = np.stack([direction, across, np.cross(direction, across)])
    return np.vstack([half, -half])
