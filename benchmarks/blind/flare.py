# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Light of a bright fixture that a lens spreads over what is beside it in the image."""

import numpy as np
from scipy import ndimage

from benchmarks.blind.fattening import grid_pixels, sample_grid
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.renderer import Rendering, SAMPLES
from benchmarks.blind.shapes import FloatArray


def flared_share(view: Rendering, width: float) -> FloatArray:
    """Return how much of an error there is at each sample, 1 on the fixture, shape (h, w, 9).

    It falls by the exponential of the way to the nearest sample that sees the fixture.

    Args:
        view: what is there.
        width: over which it falls to a third [px].
    """
    bright = sample_grid(view.labels) == FIXTURE
    if not bright.any():
        return np.zeros(view.depth.shape)
    away = ndimage.distance_transform_edt(~bright) / SAMPLES
    return grid_pixels(np.exp(-away / width))
