# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor that reads every other row in one pass, and the rows between them in a second one."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.blind.renderer import Rendering


def interlaced(passes: Sequence[Rendering]) -> Rendering:
    """Return one image of two passes: even rows, from 0, of the first, odd ones of the second."""
    row, column = min(view.row for view in passes), min(view.column for view in passes)
    height = max(view.row + view.depth.shape[0] for view in passes) - row
    width = max(view.column + view.depth.shape[1] for view in passes) - column
    shape = (height, width, passes[0].depth.shape[2])
    depth, labels, facing = np.full(shape, np.inf), np.full(shape, -1), np.ones(shape)
    for number, view in enumerate(passes):
        lines = view.row + np.arange(view.depth.shape[0])
        own = lines % 2 == number
        across = slice(view.column - column, view.column - column + view.depth.shape[1])
        depth[lines[own] - row, across] = view.depth[own]
        labels[lines[own] - row, across] = view.labels[own]
        facing[lines[own] - row, across] = view.facing[own]
    return replace(passes[0], row=row, column=column, depth=depth, labels=labels, facing=facing)
