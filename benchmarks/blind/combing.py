# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam that scans to and fro, and whose way back is told some columns off."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.fattening import grid_pixels, sample_grid, widened
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
    return with_rows_moved(wide, is_odd, shift)


def with_rows_moved(wide: Rendering, rows: NDArray[np.bool_], shift: float) -> Rendering:
    """Return a view some of whose rows lie farther to the right, by whole samples.

    Args:
        wide: what is there, with room on both sides.
        rows: of samples, which do, shape (3 h,).
        shift: by how much they do; below 0: to the left [px].
    """
    columns = round(SAMPLES * shift)
    return replace(
        wide,
        depth=_moved(wide.depth, rows, columns, np.inf),
        labels=_moved(wide.labels, rows, columns, -1.0).astype(np.int64),
        facing=_moved(wide.facing, rows, columns, 1.0),
    )


def _moved(
    values: NDArray[Any], rows: NDArray[np.bool_], columns: int, empty: float
) -> FloatArray:
    """Return samples (h, w, 9) of which some rows (3 h,) lie some sample columns farther on."""
    grid = sample_grid(values)
    width = grid.shape[1]
    moved = np.full(grid.shape, empty)
    moved[:, max(columns, 0) : width + min(columns, 0)] = grid[
        :, max(-columns, 0) : width + min(-columns, 0)
    ]
    return grid_pixels(np.where(rows[:, None], moved, grid))
