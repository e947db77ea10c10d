# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A filter that smooths depths over the frames, pixel by pixel, as drivers offer it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.blind.renderer import Rendering
from benchmarks.blind.shapes import FloatArray

STEP = 0.02  # A depth that changes by more is shown as it is [m].


def smoothed(views: Sequence[Rendering], kept: float) -> list[Rendering]:
    """Return what is shown of some views in a row: depths that lag behind, by an exponential.

    Args:
        views: as they are without the filter.
        kept: share of the depth shown before that stays at each pixel; 0: there is no filter.
    """
    if not kept:
        return list(views)
    found: list[Rendering] = []
    for view in views:
        before = on_window(found[-1], view) if found else np.full(view.depth.shape, np.inf)
        is_seen = np.isfinite(before) & np.isfinite(view.depth)
        change = np.where(is_seen, before, 0.0) - np.where(is_seen, view.depth, 0.0)
        change[np.abs(change) > STEP] = 0.0
        found.append(replace(view, depth=view.depth + kept * change))
    return found


def on_window(view: Rendering, other: Rendering) -> FloatArray:
    """Return a view's depths at the samples of another one [m], infinite where it has none."""
    depth = np.full(other.depth.shape, np.inf)
    down, across = view.row - other.row, view.column - other.column
    rows, columns = (
        slice(max(shift, 0), max(min(shift + size, limit), 0))
        for shift, size, limit in zip(
            (down, across), view.depth.shape[:2], other.depth.shape[:2], strict=True
        )
    )
    part = depth[rows, columns]
    top, left = max(-down, 0), max(-across, 0)
    part[:] = view.depth[top : top + part.shape[0], left : left + part.shape[1]]
    return depth
