# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A harness of wires along a body's upper side, one of which ends at each of its gauges."""

import numpy as np

from benchmarks.blind.shapes import FloatArray


def wires_share(share: FloatArray, gauges: tuple[float, ...]) -> FloatArray:
    """Return which part of a harness's wires goes on beyond places, 1 at the clamp.

    Args:
        share: of the free length, any shape.
        gauges: shares at which a wire ends each; empty: there is no wire.
    """
    beyond = np.asarray(share)[..., None] < np.array(gauges)
    return np.asarray(beyond.sum(axis=-1) / max(len(gauges), 1))
