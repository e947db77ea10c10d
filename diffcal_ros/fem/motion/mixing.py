# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Faster rounds of a fixed-point iteration by what the last ones did (Anderson 1965).

For a linear problem it finds what GMRES would from the same rounds (Walker and Ni 2011), without
any product with its matrix.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_KEPT = 6
# Directions that say the same to this share are not told apart.
_ROUNDING = 1e-14


class Mixing:
    """Memory of the last rounds of x' = x + g(x)."""

    def __init__(self) -> None:
        self._moves: deque[FloatArray] = deque(maxlen=_KEPT)
        self._changes: deque[FloatArray] = deque(maxlen=_KEPT)
        self._last: tuple[FloatArray, FloatArray] | None = None

    def step(self, place: FloatArray, change: FloatArray) -> FloatArray:
        """Return the step to take, shape (n,).

        Args:
            place: x, shape (n,).
            change: g(x), which vanishes where the iteration ends, shape (n,).
        """
        if self._last is not None:
            self._moves.append(place - self._last[0])
            self._changes.append(change - self._last[1])
        self._last = place, change
        if not self._changes:
            return change
        changes = np.array(self._changes)
        products = changes @ changes.T
        scales = np.sqrt(np.maximum(products.diagonal(), 1e-300))
        scaled = products / np.outer(scales, scales) + _ROUNDING * np.eye(len(scales))
        weights = np.linalg.solve(scaled, (changes @ change) / scales) / scales
        return change - weights @ (changes + np.array(self._moves))
