# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An imager whose left and right half are read out by circuits of their own."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def tap_share(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how much of an error each column's circuit has, shape (h, w, 1).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say beyond which column the right half begins, and how much the left one errs the
            other way.
    """
    height, width = rendering.depth.shape[:2]
    columns = rendering.column + np.arange(width) - (setup.camera.cx + faults.depth_spot[0])
    by_column = np.where(columns > 0.0, 1.0, -faults.depth_back)
    return np.broadcast_to(by_column, (height, width))[..., None]
