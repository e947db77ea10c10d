# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Newton's rings between a lens and a window that touches it."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def ring_error(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray | float:
    """Return an error that swings by the square of the way from where both touch [m], (h, w, 1).

    The gap of a round lens and a flat window grows by that square, and light that goes twice more
    through it is ahead or behind by its phase (Hecht, Optics, sec. 9.4: fringes of equal
    thickness).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say how large the error is, where both touch, and how wide the first ring is.
    """
    if not faults.rings:
        return 0.0
    height, width = rendering.depth.shape[:2]
    across, down = faults.rings_at
    rows = rendering.row + np.arange(height)[:, None] - (setup.camera.cy + down)
    columns = rendering.column + np.arange(width)[None] - (setup.camera.cx + across)
    turns = (rows**2 + columns**2) / faults.rings_radius**2
    angles = 2.0 * np.pi * turns + faults.rings_phase
    return np.asarray(1e-3 * faults.rings * np.sin(angles))[..., None]
