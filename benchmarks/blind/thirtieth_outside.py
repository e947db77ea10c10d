# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirtieth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.004, 0.010)  # Of the upper side at the tip [m].
_MOST_LACKING = 0.65  # Of the height.


def underfilled(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much a body lacks at its tip whose mould was filled aslant, with the clamp low."""
    shape, half = setup.shape, 0.5 * setup.shape.section[1]
    low, high = shape.place(np.array([[shape.length, 0.0, end] for end in (-half, half)]))
    lacking = _MOVES[size] / float(np.linalg.norm(high - low))
    share = min(number(lacking, random), _MOST_LACKING)
    return Effect('underfilled', {'share': share}, 'of the height', {'underfilled': share})


def spoked(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw an error of depth of a window that the screws around it press."""
    spot = random.uniform(-40.0, 40.0, 2)
    changes = {
        'spoked': number((2.0, 4.0, 10.0)[size], random),
        'spoked_at': (round(float(spot[0]), 3), round(float(spot[1]), 3)),
        'spoked_count': int(random.integers(5, 10)),
        'spoked_phase': round(float(random.uniform(0.0, 2.0 * np.pi)), 4),
    }
    return Effect('spoked', {'error': changes['spoked']}, 'mm', changes)


THIRTIETH_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (underfilled, spoked)
}
