# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that was rolled up from sheets of rubber, each of which ends sooner to the clamp."""

import numpy as np

from benchmarks.blind.shapes import FloatArray


def sheet_value(share: FloatArray, count: int) -> FloatArray:
    """Return how much sheets lack that do not reach to a place, 1 at the clamp and 0 at the tip.

    There is one more of them after each step, and log E goes with the logarithm of how many.

    Args:
        share: of the free length, any shape.
        count: of sheets at the tip, at least 2; steps are alike in length.
    """
    if count < 2:
        return np.zeros(np.shape(share))
    sheets = np.clip(np.floor(count * np.asarray(share)), 0, count - 1) + 1.0
    return np.asarray(1.0 - np.log(sheets) / np.log(count))
