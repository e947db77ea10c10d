# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A greasy window, of which a wiper's arm cleans what is nearer to its hinge than its end."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray

BLUR = 2.0  # Of the edge, which is far nearer than what a lens is focused on [px].


def wiped_share(
    rendering: Rendering, setup: Setup, faults: Faults, reach: float | None = None
) -> FloatArray:
    """Return how much of an error there is of what is seen through grease, shape (h, w, 1).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say where the hinge is from the principal point, and how far a wiper reaches.
        reach: how far it does [px]; None: as `faults` say.
    """
    height, width = rendering.depth.shape[:2]
    across, down = faults.depth_spot
    rows = rendering.row + np.arange(height)[:, None] - (setup.camera.cy + down)
    columns = rendering.column + np.arange(width)[None] - (setup.camera.cx + across)
    edge = faults.depth_width if reach is None else reach
    beyond = (np.hypot(rows, columns) - edge) / BLUR
    return np.asarray(0.5 * (1.0 + np.tanh(beyond)))[..., None]
