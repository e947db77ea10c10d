# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rotations and rigid transforms."""

import numpy as np

from benchmarks.blind.shapes import FloatArray


def rotation(vector: FloatArray) -> FloatArray:
    """Return the matrix of a rotation vector [rad], shape (3, 3)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def rigid(matrix: FloatArray, translation: FloatArray) -> FloatArray:
    """Return the transform x -> matrix x + translation, shape (4, 4)."""
    whole = np.eye(4)
    whole[:3, :3] = matrix
    whole[:3, 3] = translation
    return whole


def about(matrix: FloatArray, center: FloatArray, shift: FloatArray) -> FloatArray:
    """Return a rotation about a point, then a shift, shape (4, 4)."""
    return rigid(matrix, center - matrix @ center + shift)


def applied(matrix: FloatArray, points: FloatArray) -> FloatArray:
    """Apply a rigid transform to points, shape (..., 3)."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]
