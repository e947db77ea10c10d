# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A mould that gave way at its end: the tip is thicker, like that of a club."""

import numpy as np
from numpy.typing import NDArray

_FROM = 0.65  # Share of the free length from which on a body is thicker.


def clubbing(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much of the most a section is larger, 1 at the tip, by half a cosine's wave.

    Args:
        share: of the free length, any shape.
    """
    beyond = np.clip((share - _FROM) / (1.0 - _FROM), 0.0, 1.0)
    return np.asarray(0.5 * (1.0 - np.cos(np.pi * beyond)))
