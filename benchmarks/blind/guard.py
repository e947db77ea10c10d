# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sheet of acrylic that was bent before a sensor, to guard that from splashes."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.peeling import ways_aslant
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def guard_share(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how much of a bent sheet's error there is, shape (h, w, 1).

    A ray that meets a sheet at an angle has a longer way in it, by the square of that as long as
    it is small; along the line about which the sheet was bent it is alike.

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say where the sheet is met squarely, across which way it is bent, and how far off
            there is all of the error.
    """
    return np.asarray((ways_aslant(rendering, setup, faults) / faults.depth_width) ** 2)[..., None]
