# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pump that doses hardener by strokes, more and more of it in each."""

import numpy as np

from benchmarks.blind.shapes import FloatArray


def dosed_value(share: FloatArray, at: float, wave: float) -> FloatArray:
    """Return how hard rubber is that was dosed by strokes, -1/2 to 1/2: a sawtooth.

    Args:
        share: of the free length, any shape.
        at: share at which one of the strokes begins, softest.
        wave: share that one stroke fills.
    """
    return np.asarray((share - at) / wave % 1.0 - 0.5)
