# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A filter over time that was left on, and still has a part of what was seen before."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.renderer import Rendering


def ghosted(now: Rendering, before: Rendering, share: float) -> Rendering:
    """Return a view with a share of an earlier one's depth, wherever both see something.

    Args:
        now: what is there.
        before: what was there; its window may lie elsewhere in the image.
        share: of the depth that is told, the earlier one's.
    """
    earlier = np.full(now.depth.shape, np.inf)
    height, width = now.depth.shape[:2]
    down, across = before.row - now.row, before.column - now.column
    top, left = max(down, 0), max(across, 0)
    bottom = min(down + before.depth.shape[0], height)
    right = min(across + before.depth.shape[1], width)
    if top < bottom and left < right:
        part = before.depth[top - down : bottom - down, left - across : right - across]
        earlier[top:bottom, left:right] = part
    both = np.isfinite(now.depth) & np.isfinite(earlier)
    mixed = (1.0 - share) * now.depth + share * np.where(both, earlier, 0.0)
    return replace(now, depth=np.where(both, mixed, now.depth))
