# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A time around which something is another one than it is in all of a recording."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class TimeKnot:
    """A knot of what goes straight from knot to knot; the outermost reach as far as anything.

    Attributes:
        at: its time [s].
        spacing: to the knots beside it [s].
        is_first: whether there is none before it.
        is_last: whether there is none after it.
    """

    at: float
    spacing: float
    is_first: bool = False
    is_last: bool = False

    def weights(self, times: FloatArray | float) -> FloatArray:
        """Return by how much what it has counts at some times [s]: 1 at its own, as `times`."""
        off = (np.asarray(times, dtype=np.float64) - self.at) / self.spacing
        off = np.where((off < 0.0) & self.is_first | (off > 0.0) & self.is_last, 0.0, off)
        return np.asarray(np.maximum(1.0 - np.abs(off), 0.0))

    def slope(self, time: float) -> float:
        """Return the derivative of that by the time [1/s]; at a knot that of what follows."""
        off = (time - self.at) / self.spacing
        if -1.0 <= off < 0.0 and not self.is_first:
            return 1.0 / self.spacing
        if 0.0 <= off < 1.0 and not self.is_last:
            return -1.0 / self.spacing
        return 0.0

    def since(self, time: float) -> 'TimeKnot':
        """Return it on an axis that begins at a time [s]."""
        return replace(self, at=self.at - time)


def knots_between(first: float, last: float, count: int) -> tuple[TimeKnot, ...]:
    """Return so many knots, evenly from a first time to a last one [s]."""
    times, spacing = np.linspace(first, last, count), (last - first) / (count - 1)
    return tuple(
        TimeKnot(float(time), spacing, number == 0, number == count - 1)
        for number, time in enumerate(times)
    )
