# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depths that err once a beam comes to a body, until its receiver has settled."""

import numpy as np

from benchmarks.blind.fattening import grid_pixels, sample_grid
from benchmarks.blind.renderer import Rendering, SAMPLES
from benchmarks.blind.shapes import FloatArray


def trailing_share(view: Rendering, width: float) -> FloatArray:
    """Return how much of an error there is at each sample, shape (h, w, 9).

    A beam goes down each column. Where it comes to something the error is all there; from there
    on it falls by the exponential of the way.

    Args:
        view: what is there.
        width: over which it falls to a third [px].
    """
    seen = np.isfinite(sample_grid(view.depth))
    rows = np.broadcast_to(np.arange(len(seen))[:, None], seen.shape)
    before = np.vstack([np.zeros((1, seen.shape[1]), dtype=bool), seen[:-1]])
    begun = np.maximum.accumulate(np.where(seen & ~before, rows, 0), axis=0)
    return grid_pixels(np.exp((begun - rows) / (SAMPLES * width)))
