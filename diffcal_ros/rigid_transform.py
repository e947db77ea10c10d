# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigid transforms as (4, 4) matrices named `target_from_source`."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]

_ORTHONORMAL_TOLERANCE = 1e-4  # Transforms in files carry six or more digits.


def rotation_matrix(rotation_vector: FloatArray) -> FloatArray:
    """Turn axis times angle [rad], shape (3,), into a matrix, shape (3, 3)."""
    matrix: FloatArray = Rotation.from_rotvec(rotation_vector).as_matrix()
    return matrix


def rotation_vector(rotation: FloatArray) -> FloatArray:
    """Turn a rotation matrix into axis times angle [rad], shape (3,) (NaN of no finite one)."""
    if not np.isfinite(rotation).all():
        return np.full(3, np.nan)
    vector: FloatArray = Rotation.from_matrix(rotation).as_rotvec()
    return vector


def cross_matrix(vector: FloatArray) -> FloatArray:
    """Return the matrix of the cross product with `vector`, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def quaternion_xyzw(rotation: FloatArray) -> FloatArray:
    """Turn a rotation matrix into a unit quaternion (x, y, z, w) with w >= 0.

    NaN where the matrix is not finite: whoever reads a quaternion refuses those.
    """
    if not np.isfinite(rotation).all():
        return np.full(4, np.nan)
    quaternion: FloatArray = Rotation.from_matrix(rotation).as_quat(canonical=True)
    return quaternion


def rotation_from_quaternion(quaternion: FloatArray) -> FloatArray:
    """Turn a quaternion (x, y, z, w), not necessarily of unit length, into a matrix."""
    q = np.asarray(quaternion, dtype=np.float64)
    length = float(np.linalg.norm(q))
    if not np.isfinite(length) or length < 1e-9:
        raise ValueError(f'quaternion is {q.tolist()}: its length must be finite and not zero')
    matrix: FloatArray = Rotation.from_quat(q).as_matrix()
    return matrix


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
