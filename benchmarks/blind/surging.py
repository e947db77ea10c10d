# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A mixing pump that surged when it was switched on, and came to rest while a mould filled."""

import numpy as np

from benchmarks.blind.shapes import FloatArray


def surged_value(share: FloatArray, wave: float, width: float) -> FloatArray:
    """Return by how much the hardener was off its dose, 1 where the pump began: a damped wave.

    Args:
        share: of the free length, from where it began, any shape.
        wave: share that fills while the pump surges once.
        width: share over which it surges by a third of what it did.
    """
    return np.asarray(np.exp(-share / width) * np.cos(2.0 * np.pi * share / wave))
