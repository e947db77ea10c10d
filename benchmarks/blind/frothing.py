# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rubber in whose mould bubbles rose to one edge, and stayed there."""

import numpy as np

from benchmarks.blind.shapes import FloatArray


def froth_share(share: FloatArray, height: FloatArray) -> FloatArray:
    """Return how many bubbles are at places of a mould whose clamp's end stood higher, 1 at most.

    They fall evenly from the upper side to the lower one, and from the clamp to the tip.

    Args:
        share: of the free length, any shape.
        height: -1 at the lower face and 1 at the upper one, that shape.
    """
    up = np.clip(0.5 * (1.0 + height), 0.0, 1.0)
    return np.asarray(up * np.clip(1.0 - share, 0.0, 1.0))
