# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Light that comes to a body by way of something bright beside it, and is late at the sensor."""

import numpy as np

from benchmarks.blind.later_faults import Vector
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def bounced_share(rendering: Rendering, setup: Setup, point: Vector) -> FloatArray:
    """Return how much of an error of depth is there, 1 where the camera looks, shape (h, w, 9).

    A small bright sheet lights a place by the inverse square of its distance. What that adds to
    a depth is in proportion, as long as it is little beside the light that comes straight
    (Jimenez et al. 2014, Image Vis. Comput. 32).

    Args:
        rendering: what is seen.
        setup: with its camera, which looks at the world's origin.
        point: where the sheet is, world [m].
    """
    height, width = rendering.depth.shape[:2]
    camera, stored = setup.camera, setup.depth_from_world
    distance = float(np.linalg.norm(stored[:3, 3]))
    seen = np.where(np.isfinite(rendering.depth), rendering.depth, distance)
    across = (rendering.column + np.arange(width) - camera.cx) / camera.fx
    down = (rendering.row + np.arange(height) - camera.cy) / camera.fy
    sheet = stored[:3, :3] @ np.array(point) + stored[:3, 3]
    squares = (across[None, :, None] * seen - sheet[0]) ** 2
    squares = squares + (down[:, None, None] * seen - sheet[1]) ** 2 + (seen - sheet[2]) ** 2
    return np.asarray(float(np.square(point).sum()) / squares)
