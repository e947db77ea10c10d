# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How squarely a camera meets a surface."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def facing_cosines(points: FloatArray, triangles: NDArray[np.int32]) -> FloatArray:
    """Return the cosine between each triangle's normal and its line of sight, shape (F,).

    Args:
        points: camera frame [m], shape (N, 3).
        triangles: outward triangles, shape (F, 3).
    """
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    towards = -(a + b + c)
    lengths = np.linalg.norm(normal, axis=1) * np.linalg.norm(towards, axis=1)
    return np.einsum('fi,fi->f', normal, towards) / np.maximum(lengths, 1e-30)
