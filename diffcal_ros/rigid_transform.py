# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigid transforms as (4, 4) matrices named `target_from_source`."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ORTHONORMAL_TOLERANCE = 1e-4  # Transforms in files carry six or more digits.


def rotation_matrix(rotation_vector: FloatArray) -> FloatArray:
    """Turn a rotation vector into a matrix (Rodrigues).

    Args:
        rotation_vector: axis times angle [rad], shape (3,).

    Returns:
        Rotation, shape (3, 3).
    """
    vector = np.asarray(rotation_vector, dtype=np.float64)
    angle = float(np.linalg.norm(vector))
    cross = cross_matrix(vector)
    if angle < 1e-7:
        return np.eye(3) + cross + 0.5 * cross @ cross
    return (
        np.eye(3)
        + np.sin(angle) / angle * cross
        + (1.0 - np.cos(angle)) / angle**2 * cross @ cross
    )


def rotation_vector(rotation: FloatArray) -> FloatArray:
    """Turn a rotation matrix into axis times angle [rad], shape (3,)."""
    x, y, z, w = quaternion_xyzw(rotation)
    sine = float(np.sqrt(x * x + y * y + z * z))
    if sine < 1e-12:
        return 2.0 * np.array([x, y, z])
    angle = 2.0 * np.arctan2(sine, w)
    return np.array([x, y, z]) * (angle / sine)


def cross_matrix(vector: FloatArray) -> FloatArray:
    """Return the matrix of the cross product with `vector`, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def quaternion_xyzw(rotation: FloatArray) -> FloatArray:
    """Turn a rotation matrix into a unit quaternion (x, y, z, w) with w >= 0."""
    m = np.asarray(rotation, dtype=np.float64)
    # Four candidates, each exact where its own component is large (Shepperd's method).
    squares = np.array(
        [
            1.0 + m[0, 0] - m[1, 1] - m[2, 2],
            1.0 - m[0, 0] + m[1, 1] - m[2, 2],
            1.0 - m[0, 0] - m[1, 1] + m[2, 2],
            1.0 + m[0, 0] + m[1, 1] + m[2, 2],
        ]
    )
    pick = int(np.argmax(squares))
    rows = np.array(
        [
            [squares[0], m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
            [m[1, 0] + m[0, 1], squares[1], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[2], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]],
        ]
    )
    quaternion = rows[pick] / np.linalg.norm(rows[pick])
    return quaternion if quaternion[3] >= 0.0 else -quaternion


def rotation_from_quaternion(quaternion: FloatArray) -> FloatArray:
    """Turn a quaternion (x, y, z, w), not necessarily of unit length, into a matrix."""
    q = np.asarray(quaternion, dtype=np.float64)
    length = float(np.linalg.norm(q))
    if not np.isfinite(length) or length < 1e-9:
        raise ValueError(f'quaternion is {q.tolist()}: its length must be finite and not zero')
    x, y, z, w = q / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def transform(rotation: FloatArray, translation: FloatArray) -> FloatArray:
    """Put a (3, 3) rotation and a (3,) translation [m] into one (4, 4) matrix."""
    target_from_source = np.eye(4)
    target_from_source[:3, :3] = rotation
    target_from_source[:3, 3] = translation
    return target_from_source


def inverse(target_from_source: FloatArray) -> FloatArray:
    """Return `source_from_target`."""
    rotation = target_from_source[:3, :3]
    return transform(rotation.T, -rotation.T @ target_from_source[:3, 3])


def apply(target_from_source: FloatArray, points_source: FloatArray) -> FloatArray:
    """Move points, shape (..., 3) [m], from the source to the target frame."""
    return points_source @ target_from_source[:3, :3].T + target_from_source[:3, 3]


def looking_at(target: FloatArray, from_direction: FloatArray, up: FloatArray) -> FloatArray:
    """Return `view_from_world` of a viewer who looks at a point: x right, y down, z forward.

    Args:
        target: what is looked at, in the world frame [m], shape (3,).
        from_direction: from the target to the viewer [m], shape (3,); not along `up`.
        up: direction that points up in the view, shape (3,).
    """
    forward = -from_direction / np.linalg.norm(from_direction)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    world_from_view = transform(
        np.stack([right, np.cross(forward, right), forward], axis=1), target + from_direction
    )
    return inverse(world_from_view)


def check_rigid(name: str, matrix: FloatArray) -> FloatArray:
    """Return the matrix as float64, or say why it is no rigid transform.

    Raises:
        ValueError: naming `name`, what was given and what is needed.
    """
    given = np.asarray(matrix, dtype=np.float64)
    if given.shape != (4, 4):
        raise ValueError(f'{name} has shape {given.shape}: a rigid transform is 4x4')
    if not np.isfinite(given).all():
        raise ValueError(f'{name} holds NaN or Inf: a rigid transform is finite')
    rotation = given[:3, :3]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > _ORTHONORMAL_TOLERANCE:
        raise ValueError(f'{name} is not rigid: its 3x3 part must be a rotation (orthonormal)')
    if np.linalg.det(rotation) < 0.0:
        raise ValueError(f'{name} mirrors: its 3x3 part has determinant -1, a rotation has +1')
    if np.abs(given[3] - [0.0, 0.0, 0.0, 1.0]).max() > _ORTHONORMAL_TOLERANCE:
        raise ValueError(f'{name} has last row {given[3].tolist()}: it must be 0 0 0 1')
    return given


def angle_between(first: FloatArray, second: FloatArray) -> float:
    """Return the angle [rad] of the rotation that takes one rotation matrix to another."""
    return float(np.linalg.norm(rotation_vector(first[:3, :3].T @ second[:3, :3])))
