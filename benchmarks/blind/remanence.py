# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The magnet of a ledge that is switched off: what is left of its field dies away.

Eddies in its core keep that up for a while, and it goes on drawing a pin in the end face.
"""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

Changing = Callable[[float], FloatArray]


def with_remanence(other: Changing | None, end: FloatArray, faults: Faults) -> Changing | None:
    """Return what acts on the nodes by the time since the release [N], with a magnet's pull.

    Args:
        other: what acts beside it, shape (N, 3); None: nothing.
        end: share of each node in what acts on the end face, shape (N,).
        faults: say what pull there is.
    """
    if not faults.remanent:
        return other
    pull = faults.remanent * end[:, None] * np.array(faults.remanent_way)

    def forces(time: float) -> FloatArray:
        drawn = float(np.exp(-time / faults.remanent_time)) * pull
        return drawn if other is None else drawn + other(time)

    return forces
