# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cable that lost bytes: what comes after them is some columns to the side."""

import numpy as np

from benchmarks.blind.combing import with_rows_moved
from benchmarks.blind.fattening import widened
from benchmarks.blind.renderer import Camera, Rendering, SAMPLES


def lapsed(view: Rendering, camera: Camera, shift: float, row: int) -> Rendering:
    """Return a view of which all from a row on lies farther to the right, by whole samples.

    Args:
        view: what is there.
        camera: says where the image ends.
        shift: by how much it does; below 0: to the left [px].
        row: of the image, from which on, downwards.
    """
    if not shift:
        return view
    wide = widened(view, camera, int(np.ceil(abs(shift))))
    is_after = np.repeat(wide.row + np.arange(len(wide.depth)) >= row, SAMPLES)
    return with_rows_moved(wide, round(SAMPLES * shift) * is_after)
