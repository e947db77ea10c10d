# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-ninth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.clubbing import clubbing
from benchmarks.blind.setups import Setup
from benchmarks.blind.slender import even_sag, levers, SHARES

_MOVES = (0.002, 0.004, 0.010)  # Of the tip or its sides, or of what is seen to the side [m].
_MOST_CLUBBED = 0.8  # Of the section.


def clubbed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much thicker a body is at its tip, where the mould gave way."""
    shape, ends = setup.shape, np.array(setup.shape.breaks[1])[[0, -1]]
    low, high = shape.place(np.array([[shape.length, end, 0.0] for end in ends]))
    by_sides = 2.0 * _MOVES[size] / float(np.linalg.norm(high - low))
    listed = np.linspace(0.0, _MOST_CLUBBED, 101)
    heavier = (1.0 + listed[:, None] * clubbing(SHARES)) ** 2 - 1.0
    sinks = even_sag(setup) * heavier @ levers(setup) / len(SHARES)
    # Whichever is seen first: how far its sides go out, or how far its tip sinks.
    by_weight = float(np.interp(_MOVES[size], sinks, listed))
    share = number(min(by_sides, by_weight, _MOST_CLUBBED), random)
    return Effect('clubbed', {'share': share}, 'of the section', {'clubbed': share})


def jittered(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much the lines of a scan are told to begin too soon or too late."""
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    changes = {
        'jittered': number(_MOVES[size] * setup.camera.fx / distance, random),
        'jittered_seed': int(random.integers(1, 1_000_000)),
    }
    return Effect('jittered', {'shift': changes['jittered']}, 'px at most', changes)


TWENTYNINTH_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (clubbed, jittered)
}
