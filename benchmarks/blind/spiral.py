# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor whose mirror scans along a spiral, and lags behind where it comes round."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def spiral_error(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray | float:
    """Return an error by the sine of how far a spiral has come round [m], shape (h, w, 1).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say how large the error is, amid which place it begins, and how far apart the
            turns of the spiral are.
    """
    if not faults.spiralled:
        return 0.0
    height, width = rendering.depth.shape[:2]
    across, down = faults.spiralled_at
    rows = rendering.row + np.arange(height)[:, None] - (setup.camera.cy + down)
    columns = rendering.column + np.arange(width)[None] - (setup.camera.cx + across)
    turns = np.hypot(rows, columns) / faults.spiralled_apart
    angles = 2.0 * np.pi * turns - np.arctan2(rows, columns)
    return np.asarray(1e-3 * faults.spiralled * np.sin(angles))[..., None]
