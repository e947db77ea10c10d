# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor whose columns are read out over one wire each, where light of all rows adds up."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.shapes import FloatArray


def crosstalk_error(rendering: Rendering, faults: Faults) -> FloatArray | float:
    """Return an error by how much of a column sees something [m], shape (1, w, 1).

    Args:
        rendering: of all that there is to see.
        faults: say how large the error is where most of a column does.
    """
    if not faults.crosstalk:
        return 0.0
    seen = np.isfinite(rendering.depth).sum(axis=(0, 2))
    return np.asarray(1e-3 * faults.crosstalk * seen / max(int(seen.max()), 1))[None, :, None]
