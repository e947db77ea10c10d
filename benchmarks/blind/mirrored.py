# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A lens that reflects a part of the light to the other side of its axis."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.ghost import ghosted
from benchmarks.blind.renderer import Camera, Rendering


def mirrored(
    view: Rendering, camera: Camera, share: float, at: tuple[float, float] = (0.0, 0.0)
) -> Rendering:
    """Return a view with a share of the depth across a place, where both sides see something.

    Args:
        view: what is there.
        camera: says where the principal point is.
        share: of the depth that is told, the other side's.
        at: where the place is from there, column and row; it is rounded to half a pixel [px].
    """
    return ghosted(view, turned_over(view, camera, at), share) if share else view


def turned_over(view: Rendering, camera: Camera, at: tuple[float, float]) -> Rendering:
    """Return a view turned by half a turn about a place, told as above."""
    height, width = view.depth.shape[:2]
    # Samples of a pixel are in rows as well: in reverse they are turned over likewise.
    depth, labels, facing = (
        values[::-1, ::-1, ::-1] for values in (view.depth, view.labels, view.facing)
    )
    return replace(
        view,
        column=int(np.rint(2.0 * (camera.cx + at[0]))) - view.column - width + 1,
        row=int(np.rint(2.0 * (camera.cy + at[1]))) - view.row - height + 1,
        depth=depth,
        labels=labels,
        facing=facing,
    )
