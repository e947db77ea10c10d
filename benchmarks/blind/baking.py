# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A mould that stood between two hot blocks, which cooled on its way from one to the other."""

import numpy as np

from benchmarks.blind.shapes import FloatArray


def baked_value(share: FloatArray, at: float, width: float) -> FloatArray:
    """Return how hot rubber was over its coolest place, 1 at the end that is farthest from that.

    By the law of a fin that gives heat to the air: the hyperbolic cosine of the way.

    Args:
        share: of the free length, any shape.
        at: that of the coolest place.
        width: share over which heat falls to a third; 0: there is none.
    """
    if not width:
        return np.zeros(np.shape(share))
    most = np.cosh(max(at, 1.0 - at) / width) - 1.0
    return np.asarray((np.cosh((share - at) / width) - 1.0) / most)
