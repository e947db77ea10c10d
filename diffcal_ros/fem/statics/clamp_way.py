# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far a clamp gives way under a body at rest, by Newton's method."""

from collections.abc import Callable

from diffcal_ros.fem.clamp import ClampResponse
from diffcal_ros.fem.statics.tangent_stiffness import EquilibriumError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Returns what the clamp should give way by, less what it does [m, rad], shape (6,), at what it
# gives way by, shape (6,), and how the body is expected to follow from where it is [m], (N, 3).
MissingAt = Callable[[FloatArray, FloatArray | None], FloatArray]

_MAX_STEPS = 60
# A clamp's response is found again where a step with it leaves more than this share.
SLOW = 0.1


def find_way(
    begin: FloatArray,
    missing_at: MissingAt,
    response_there: Callable[[], ClampResponse],
    tolerance: float,
) -> None:
    """Move a clamp until that is what the load on it asks for.

    Args:
        begin: what it gives way by at first [m, rad], shape (6,).
        missing_at: settles the body there; at first it is not said how that follows.
        response_there: how clamp and body follow where they are.
        tolerance: what it may be off by [m, rad].

    Raises:
        EquilibriumError: when it gives way without end.
    """
    gave_way, before = begin, np.inf
    response: ClampResponse | None = None
    displacement: FloatArray | None = None
    for _ in range(_MAX_STEPS):
        missing = missing_at(gave_way, displacement)
        left = float(np.abs(missing).max())
        if left < tolerance:
            return
        if response is None or left > SLOW * before:
            response = response_there()
        step, displacement = response.step(missing)
        gave_way, before = gave_way + step, left
    raise EquilibriumError(
        'the clamp gives way without end: its compliance is too large for the load'
    )
