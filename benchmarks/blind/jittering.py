# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scanning sensor whose table of when each of its lines begins is spoilt."""

import numpy as np

from benchmarks.blind.combing import with_rows_moved
from benchmarks.blind.fattening import widened
from benchmarks.blind.renderer import Camera, Rendering, SAMPLES


def jittered(view: Rendering, camera: Camera, most: float, seed: int) -> Rendering:
    """Return a view each row of which lies to a side by a draw of its own, by whole samples.

    Args:
        view: what is there.
        camera: says where the image ends.
        most: by how much a row does at most, either way, all of which is as likely [px].
        seed: of the draws, one for each row of the image.
    """
    if not most:
        return view
    wide = widened(view, camera, int(np.ceil(most)))
    drawn = np.random.default_rng(seed).uniform(-most, most, camera.height)
    own = drawn[wide.row : wide.row + len(wide.depth)]
    columns = np.round(SAMPLES * own).astype(np.int64)
    return with_rows_moved(wide, np.repeat(columns, SAMPLES))
