# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor's round window, into which something pressed a dent."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def dented_share(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how deep a dent is where pixels look through it, 1 where deepest, (h, w, 1).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say where the dent is from the principal point, and how far from there the rim is.
    """
    height, width = rendering.depth.shape[:2]
    (across, down), camera = faults.depth_spot, setup.camera
    columns = rendering.column + np.arange(width)[None] - (camera.cx + across)
    rows = rendering.row + np.arange(height)[:, None] - (camera.cy + down)
    return plate_share(np.hypot(rows, columns) / faults.depth_width)[..., None]


def plate_share(way: FloatArray) -> FloatArray:
    """Return how far a round plate is bent that is held at its rim and pressed amid it, 1 there.

    By 1 - r^2 + 2 r^2 log r (Timoshenko & Woinowsky-Krieger 1959, Theory of Plates and Shells).

    Args:
        way: from the middle, over that to the rim, any shape; beyond that nothing bends.
    """
    inside = np.clip(way, 1e-12, 1.0)
    return np.asarray(1.0 - inside**2 + 2.0 * inside**2 * np.log(inside))
