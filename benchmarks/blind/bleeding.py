# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depths that err near an outline, where a lens or a filter mixes in what lies behind."""

import numpy as np
from scipy import ndimage

from benchmarks.blind.fattening import grid_pixels, sample_grid
from benchmarks.blind.renderer import Rendering, SAMPLES
from benchmarks.blind.shapes import FloatArray


def bleeding_share(view: Rendering, width: float) -> FloatArray:
    """Return how much of an error there is at each sample, 1 on the outline, shape (h, w, 9).

    It falls by the exponential of the way to the nearest sample that sees nothing.

    Args:
        view: what is there.
        width: over which it falls to a third [px].
    """
    away = ndimage.distance_transform_edt(np.isfinite(sample_grid(view.depth))) / SAMPLES
    return grid_pixels(np.exp(-away / width))
