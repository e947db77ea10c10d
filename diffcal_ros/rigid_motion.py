# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Small rigid motions of the body as the camera sees it, and tilts of gravity."""

from diffcal_ros.rigid_transform import cross_matrix, rotation_matrix
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def tilt_axes(gravity: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit axes across gravity, the first as close to world x as can be."""
    down = -upwards(gravity)
    seed = np.eye(3)[int(np.argmin(np.abs(down)))]
    if abs(down[0]) < 0.9:
        seed = np.array([1.0, 0.0, 0.0])
    first = seed - (seed @ down) * down
    first /= np.linalg.norm(first)
    return first, np.cross(down, first)


def upwards(gravity: FloatArray) -> FloatArray:
    """Return the unit vector against gravity, shape (3,); world y without any."""
    length = float(np.linalg.norm(gravity))
    return -gravity / length if length > 0.0 else np.array([0.0, 1.0, 0.0])


def moved(points: FloatArray, twist: FloatArray, pivot: FloatArray) -> FloatArray:
    """Turn points about a pivot, then shift them."""
    if not twist.any():
        return points
    return (points - pivot) @ rotation_matrix(twist[3:]).T + pivot + twist[:3]


def moved_by(points: FloatArray, twist: FloatArray, pivot: FloatArray, axis: int) -> FloatArray:
    """Return the derivative of `moved` by one of its six numbers, shape (N, 3)."""
    if axis < 3:
        return np.broadcast_to(np.eye(3)[axis], points.shape)
    turned = (points - pivot) @ rotation_matrix(twist[3:]).T
    spin = _left_jacobian(twist[3:])[:, axis - 3]
    return np.cross(spin, turned)


def _left_jacobian(vector: FloatArray) -> FloatArray:
    """Return d(rotation) as spin per unit of a rotation vector, shape (3, 3)."""
    angle = float(np.linalg.norm(vector))
    cross = cross_matrix(vector)
    if angle < 1e-5:
        return np.eye(3) + 0.5 * cross
    return (
        np.eye(3)
        + (1.0 - np.cos(angle)) / angle**2 * cross
        + (angle - np.sin(angle)) / angle**3 * cross @ cross
    )
