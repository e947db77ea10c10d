# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fan that lies on the bench and blows up, below a body."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray


def updraught_push(places: FloatArray, faults: Faults) -> FloatArray:
    """Return by how much parts are pushed up [m/s^2], shape (N,).

    It falls by the exponential of the square of the distance from the stream's upright axis.

    Args:
        places: world [m], shape (N, 3).
        faults: say where the axis is, how wide the stream, and how strong on its axis.
    """
    x, z = faults.updraught_at
    squares = (places[:, 0] - x) ** 2 + (places[:, 2] - z) ** 2
    return np.asarray(faults.updraught * np.exp(-squares / faults.updraught_width**2))
