# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where on its triangle a camera sees a point.

A point of a ray is in the plane of three corners where it is a sum of them; by Cramer's rule their
shares are as the volumes that the ray spans with each two of the others.
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def corner_pairs(points: FloatArray, triangles: NDArray[np.int32]) -> FloatArray:
    """Return the cross products of each two corners of triangles [m^2], shape (F, 3, 3).

    Args:
        points: camera frame [m], shape (N, 3).
        triangles: shape (F, 3).
    """
    corners = points[triangles]
    return np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))


def corner_weights(pairs: FloatArray, directions: FloatArray) -> FloatArray:
    """Return the barycentric coordinates of the points in which rays meet their triangles.

    Args:
        pairs: `corner_pairs` of the triangle of each ray, shape (n, 3, 3).
        directions: x / z and y / z of each ray, shape (n, 2).

    Returns:
        Weights of the corners, which sum to one, shape (n, 3).
    """
    volumes = np.einsum('nci,ni->nc', pairs[..., :2], directions) + pairs[..., 2]
    return np.asarray(volumes / volumes.sum(axis=1, keepdims=True))
