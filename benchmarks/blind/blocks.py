# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Images that a codec made coarse, of which each square has the mean of its depths alone."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.renderer import Rendering


def in_blocks(view: Rendering, edge: int) -> Rendering:
    """Return a view whose depths are the means of the squares in which they lie.

    Squares begin at the image's corner. What sees nothing still does, and is in no mean.

    Args:
        view: what is there.
        edge: of a square [px]; 0: there are none.
    """
    if not edge:
        return view
    height, width = view.depth.shape[:2]
    rows = (view.row + np.arange(height)) // edge
    columns = (view.column + np.arange(width)) // edge
    count = int(columns.max()) + 1
    squares = np.broadcast_to((rows[:, None] * count + columns)[..., None], view.depth.shape)
    there = np.isfinite(view.depth)
    sums = np.bincount(squares[there], weights=view.depth[there])
    means = sums / np.maximum(np.bincount(squares[there]), 1)
    depth = view.depth.copy()
    depth[there] = means[squares[there]]
    return replace(view, depth=depth)
