# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rig whose stand gives as its ledge snaps away: it lurches aside once, and comes back.

By the square of the time and its exponential, as a damper with mass to it does.
"""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray


def lurch_shift(faults: Faults, time: float) -> FloatArray:
    """Return how far a rig has lurched at a time since the release, world [m], shape (3,)."""
    since = max(time, 0.0) / faults.lurched_time
    share = 0.25 * since**2 * np.exp(2.0 - since)
    return np.asarray(1e-3 * faults.lurched * share * np.array(faults.lurched_way))


def lurch_acceleration(faults: Faults, time: float) -> FloatArray:
    """Return the same twice differentiated by the time [m/s^2], shape (3,)."""
    since = time / faults.lurched_time
    if since < 0.0:
        return np.zeros(3)
    rate = 0.25 * (2.0 - 4.0 * since + since**2) * np.exp(2.0 - since) / faults.lurched_time**2
    return np.asarray(1e-3 * faults.lurched * rate * np.array(faults.lurched_way))
