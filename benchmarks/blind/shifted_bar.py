# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A stereo sensor's bar, mounted with one end higher than the other: it bends like an S."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.peeling import ways_aslant
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def shifted_share(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how much of an error each pixel has, -1 to 1 from end to end, shape (h, w, 1).

    By the cubic of a beam whose ends are held level, one of which is higher; beyond them it is as
    there.

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say where the bar's middle is, which way it lies, and how long either half is.
    """
    way = np.clip(ways_aslant(rendering, setup, faults) / faults.depth_width, -1.0, 1.0)
    return np.asarray(0.5 * way * (3.0 - way**2))[..., None]
