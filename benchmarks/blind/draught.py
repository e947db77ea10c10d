# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A round stream of air across a bench, as that of a ventilator some way off."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray


def stream_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a stream's push is felt at places, 1 on its axis, shape (N,).

    The pressure of a free round stream falls by the square of the distance's exponential from
    its axis (Pope 2000, Turbulent Flows, sec. 5.1); along it, over a body, it hardly changes.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, world, shape (3,).
        faults: say where its axis is, and how wide it is.
    """
    along = way / max(float(np.linalg.norm(way)), 1e-30)
    beside = places - np.array(faults.tilt_point)
    squares = (beside**2).sum(axis=1) - (beside @ along) ** 2
    return np.asarray(np.exp(-squares / faults.tilt_width**2))
