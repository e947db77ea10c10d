# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor's window that broke in two and was glued again, with a bend along the seam."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.peeling import ways_aslant
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def glued_share(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how much of a glued window's error there is, shape (h, w, 1).

    It grows evenly with the way from the seam, on both sides alike, like a roof.

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say where the seam is, across which way, and how far off there is all of the error.
    """
    return np.abs(ways_aslant(rendering, setup, faults) / faults.depth_width)[..., None]
