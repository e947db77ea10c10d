# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The window of a sensor's sealed housing, which the warm air behind it bulges."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def bulged_share(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how far a window bulges where pixels look through it, 1 in its middle, (h, w, 1).

    A plate whose edges are held bulges by (1 - u^2)^2 (1 - v^2)^2 of the ways from its middle over
    those to its edges, as Ritz's method has it; it is as tall by its width as the image.

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say where the middle is from the principal point, and how far from there the
            upright edges are.
    """
    height, width = rendering.depth.shape[:2]
    (across, down), camera = faults.depth_spot, setup.camera
    half = faults.depth_width * np.array([1.0, camera.height / camera.width])
    columns = rendering.column + np.arange(width) - (camera.cx + across)
    rows = rendering.row + np.arange(height) - (camera.cy + down)
    u, v = (
        np.clip(way / edge, -1.0, 1.0) for way, edge in zip((columns, rows), half, strict=True)
    )
    return np.asarray(np.outer((1.0 - v**2) ** 2, (1.0 - u**2) ** 2))[..., None]
