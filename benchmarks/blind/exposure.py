# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How long a sensor exposes a frame, which looks for the mean of the light that comes back."""

import numpy as np

from benchmarks.blind.renderer import Rendering
from benchmarks.blind.shapes import FloatArray

_DARKEST = 1.0 / 3.0  # Cosine of the angle from which on a surface is not darker.


def returned_light(rendering: Rendering, distance: float) -> FloatArray:
    """Return the light of samples over that of what is met squarely at a distance, (h, w, 9).

    Args:
        rendering: what is there; where nothing is, it is taken for what is at that distance.
        distance: [m].
    """
    seen = np.where(np.isfinite(rendering.depth), rendering.depth, distance)
    return np.asarray(np.maximum(rendering.facing, _DARKEST) * (distance / seen) ** 2)


def exposure(rendering: Rendering, distance: float) -> float:
    """Return how long a frame is exposed, over that where all is met squarely at a distance.

    Args:
        rendering: what is there.
        distance: [m].
    """
    there = np.isfinite(rendering.depth)
    if not there.any():
        return 1.0
    return 1.0 / float(returned_light(rendering, distance)[there].mean())
