# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam that scans to and fro, and whose way back is told some columns off."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.fattening import grid_pixels, sample_grid, widened
from benchmarks.blind.paint import IntArray
from benchmarks.blind.renderer import Camera, Rendering, SAMPLES
from benchmarks.blind.shapes import FloatArray


def combed(view: Rendering, camera: Camera, shift: float) -> Rendering:
    """Return a view whose odd rows lie farther to the right, by whole samples.

    Args:
        view: what is there.
        camera: says where the image ends.
        shift: by how much they do; below 0: to the left [px].
    """
    if not shift:
        return view
    wide = widened(view, camera, int(np.ceil(abs(shift))))
    height = len(wide.depth)
    is_odd = np.repeat((wide.row + np.arange(height)) % 2 == 1, SAMPLES)
    return with_rows_moved(wide, round(SAMPLES * shift) * is_odd)


def with_rows_moved(wide: Rendering, columns: IntArray) -> Rendering:
    """Return a view whose rows lie farther to the right, by whole samples.

    Args:
        wide: what is there, with room on both sides.
        columns: of samples, by which each row of these does; below 0: to the left, shape (3 h,).
    """
    return replace(
        wide,
        depth=_moved(wide.depth, columns, np.inf),
        labels=_moved(wide.labels, columns, -1.0).astype(np.int64),
        facing=_moved(wide.facing, columns, 1.0),
    )


def _moved(values: NDArray[Any], columns: IntArray, empty: float) -> FloatArray:
    """Return samples (h, w, 9) each row of which (3 h,) lies some sample columns farther on."""
    grid = sample_grid(values)
    last = grid.shape[1] - 1
    before = np.arange(last + 1) - columns[:, None]
    moved = np.take_along_axis(grid, np.clip(before, 0, last), axis=1)
    return grid_pixels(np.where((before >= 0) & (before <= last), moved, empty))
