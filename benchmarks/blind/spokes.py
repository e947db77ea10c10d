# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor's window that screws around it press, so that it waves like a fan."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def spoke_error(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray | float:
    """Return an error by the cosine of some times the angle about a place [m], shape (h, w, 1).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say how large the error is, about which place, and how many waves go round.
    """
    if not faults.spoked:
        return 0.0
    height, width = rendering.depth.shape[:2]
    across, down = faults.spoked_at
    rows = rendering.row + np.arange(height)[:, None] - (setup.camera.cy + down)
    columns = rendering.column + np.arange(width)[None] - (setup.camera.cx + across)
    angles = faults.spoked_count * np.arctan2(rows, columns) + faults.spoked_phase
    return np.asarray(1e-3 * faults.spoked * np.cos(angles))[..., None]
