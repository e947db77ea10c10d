# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What stands before a background seen too wide, as by a sensor that matches whole blocks."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from benchmarks.blind.renderer import Camera, Rendering, SAMPLES
from benchmarks.blind.shapes import FloatArray


def fattened(view: Rendering, camera: Camera, radius: float) -> Rendering:
    """Return a view whose outlines lie farther out; what is there sees its nearest sample.

    Args:
        view: what is there.
        camera: says where the image ends.
        radius: by how much they lie farther out [px].
    """
    if not radius:
        return view
    wide = widened(view, camera, int(np.ceil(radius)))
    samples = sample_grid(wide.depth)
    away, (rows, columns) = ndimage.distance_transform_edt(
        ~np.isfinite(samples), return_indices=True
    )
    # What is too far away keeps its own sample, which sees nothing.
    far = away > SAMPLES * radius
    own_rows, own_columns = np.indices(samples.shape)
    rows, columns = np.where(far, own_rows, rows), np.where(far, own_columns, columns)
    depth, labels, facing = (
        grid_pixels(sample_grid(values)[rows, columns])
        for values in (wide.depth, wide.labels, wide.facing)
    )
    return replace(wide, depth=depth, labels=labels.astype(np.int64), facing=facing)


def widened(view: Rendering, camera: Camera, more: int) -> Rendering:
    """Return a view with a wider window, as far as the image goes."""
    height, width = view.depth.shape[:2]
    up, left = min(more, view.row), min(more, view.column)
    down = min(more, camera.height - view.row - height)
    right = min(more, camera.width - view.column - width)
    beside = ((up, down), (left, right), (0, 0))
    return Rendering(
        column=view.column - left,
        row=view.row - up,
        depth=np.pad(view.depth, beside, constant_values=np.inf),
        labels=np.pad(view.labels, beside, constant_values=-1),
        facing=np.pad(view.facing, beside, constant_values=1.0),
    )


def sample_grid(values: NDArray[Any]) -> FloatArray:
    """Lay out the samples of pixels (h, w, 9) as they lie in the image, shape (3 h, 3 w)."""
    height, width = values.shape[:2]
    blocks = values.reshape(height, width, SAMPLES, SAMPLES).swapaxes(1, 2)
    return np.asarray(blocks.reshape(height * SAMPLES, width * SAMPLES))


def grid_pixels(samples: FloatArray) -> FloatArray:
    """Put samples that are laid out so back to their pixels, shape (h, w, 9)."""
    height, width = (side // SAMPLES for side in samples.shape)
    blocks = samples.reshape(height, SAMPLES, width, SAMPLES).swapaxes(1, 2)
    return np.asarray(blocks.reshape(height, width, -1))
