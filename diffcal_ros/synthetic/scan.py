# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a camera would see without any error: depth, slant and what is there."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


class Thing(IntEnum):
    """What a pixel shows."""

    NOTHING = 0
    BODY = 1
    PLATE = 2
    BLOCK = 3
    WALL = 4


@dataclass(frozen=True)
class Scan:
    """A perfect view.

    Attributes:
        depth: z [m], shape (H, W); NaN where nothing is.
        cosine: of the angle between the surface's normal and the line of sight, shape (H, W).
        things: numbers of `Thing`, shape (H, W).
    """

    depth: FloatArray
    cosine: FloatArray
    things: IntArray

    @classmethod
    def empty(cls, height: int, width: int) -> 'Scan':
        """Return a view of nothing."""
        shape = (height, width)
        return cls(np.full(shape, np.nan), np.ones(shape), np.zeros(shape, dtype=np.int32))

    @property
    def is_empty(self) -> BoolArray:
        """Pixels that show nothing, shape (H, W)."""
        return np.isnan(self.depth)

    def in_front_of(self, other: 'Scan') -> 'Scan':
        """Return both views in one; the nearer thing hides the farther one."""
        return self._over(other, lambda mine, theirs: mine <= theirs)

    def painted_over(self, other: 'Scan') -> 'Scan':
        """Return both views in one; this one hides the other wherever it shows something."""
        return self._over(other, lambda mine, theirs: np.ones(mine.shape, dtype=bool))

    def _over(self, other: 'Scan', wins: Callable[[FloatArray, FloatArray], BoolArray]) -> 'Scan':
        own = ~self.is_empty & (other.is_empty | wins(self.depth, other.depth))
        return Scan(
            np.where(own, self.depth, other.depth),
            np.where(own, self.cosine, other.cosine),
            np.where(own, self.things, other.things).astype(np.int32),
        )
