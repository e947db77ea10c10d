# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rubber rope between two posts, which sinks as its two halves turn and grow longer."""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

_DEEPEST, _PLACES = 0.04, 4001  # How far down its force is listed [m], and at how many places.


def rope_force(sunk: FloatArray, faults: Faults) -> FloatArray:
    """Return the force by which a rope bears what sank its middle [N].

    Args:
        sunk: by how much [m].
        faults: say how far apart its posts are, how strongly it is drawn, and by how much longer.
    """
    half = faults.contact_span
    drawn = np.hypot(half, sunk)
    loose = half / (1.0 + faults.contact_drawn)
    pull = faults.contact_tension * (drawn - loose) / (half - loose)
    return np.asarray(2.0 * pull * sunk / drawn)


def rope_give(faults: Faults) -> Callable[[float], float]:
    """Return by how much a rope sinks [m] by the force on it [N]."""
    places = np.linspace(0.0, _DEEPEST, _PLACES)
    forces = rope_force(places, faults)
    return lambda force: float(np.interp(force, forces, places))
