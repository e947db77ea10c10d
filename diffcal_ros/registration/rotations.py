# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rotations spread evenly over all there are."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]

# Positive root of x^4 = x + 4.
_PSI = 1.533751168755204288118041


def spread_rotations(count: int) -> FloatArray:
    """Return rotations that cover all directions and turns evenly, shape (count, 3, 3).

    Super-Fibonacci spirals (Alexa, *Super-Fibonacci spirals: fast, low-discrepancy sampling of
    SO(3)*, CVPR 2022): of 1,500 the farthest rotation is about 17 degrees from the nearest one.

    Args:
        count: how many.
    """
    place = np.arange(count) + 0.5
    share = place / count
    near, far = np.sqrt(share), np.sqrt(1.0 - share)
    alpha, beta = 2.0 * np.pi * place / np.sqrt(2.0), 2.0 * np.pi * place / _PSI
    quaternions = np.stack(
        [near * np.sin(alpha), near * np.cos(alpha), far * np.sin(beta), far * np.cos(beta)],
        axis=1,
    )
    return np.asarray(Rotation.from_quat(quaternions).as_matrix(), dtype=np.float64)
