# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A gust of wind, as of a door that is opened while a body swings."""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen

Changing = Callable[[float], FloatArray]


def with_gust(other: Changing | None, specimen: Specimen, faults: Faults) -> Changing | None:
    """Return what acts on the nodes by the time since the release [N], with that of a gust.

    Args:
        other: what acts beside it, shape (N, 3); None: nothing.
        specimen: the body.
        faults: say what gust there is.
    """
    if not faults.gust:
        return other
    spread = specimen.areas * (specimen.shares > 0.0)
    push = faults.gust * (spread / spread.sum())[:, None] * np.array(faults.gust_way)

    def forces(time: float) -> FloatArray:
        blown = blowing(faults, time) * push
        return blown if other is None else blown + other(time)

    return forces


def blowing(faults: Faults, time: float) -> float:
    """Return how hard a gust blows at a time since the release, over the most."""
    share = (time - faults.gust_from) / faults.gust_time
    return float(np.sin(np.pi * share) ** 2) if 0.0 < share < 1.0 else 0.0
