# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Air that turns about an upright axis, as below a ventilator in the ceiling."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray


def whirled(places: FloatArray, faults: Faults) -> FloatArray:
    """Return by how much parts are pushed around the axis, world frame [m/s^2], shape (N, 3).

    The speed is that of Kaufmann's vortex (1962, Ing.-Arch. 31): it grows with the distance from
    the axis up to the radius and falls beyond; a push goes with its square.

    Args:
        places: world [m], shape (N, 3).
        faults: say where the axis is, how wide the whirl, and how strong at that radius.
    """
    x, z = faults.whirl_at
    ahead, aside = places[:, 0] - x, places[:, 2] - z
    distance = np.hypot(ahead, aside)
    far = distance / faults.whirl_radius
    speed = 2.0 * far / (1.0 + far**2)
    # Right-handed about the world's y.
    around = np.stack([aside, np.zeros(len(places)), -ahead], axis=-1)
    return np.asarray((faults.whirl * speed**2 / np.maximum(distance, 1e-12))[:, None] * around)
