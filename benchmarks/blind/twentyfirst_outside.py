# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-first set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm, where the mechanics
allow it.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.setups import Setup
from benchmarks.blind.slender import even_sag, SHARES, softness

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_FLAT = 0.8  # Share by which a body is wider at its tip at most.
_PIXEL = 0.00057  # What a pixel sees of a body [m].


def flattened(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how flat a mould was pressed towards a body's tip, which it made wider there."""
    shares = np.linspace(0.0, _MOST_FLAT, 81)
    # As long and as heavy, a section bears by its width and the cube of its height.
    softer = (1.0 + shares[:, None] * SHARES) ** 2 - 1.0
    changes = even_sag(setup) * softer @ ((1.0 - SHARES) ** 3 * softness(setup) / 50.0)
    share = float(np.interp(_MOVES[size], changes, shares))
    share = number(min(share, _MOST_FLAT * (_MOVES[size] / _MOVES[2]) ** 0.5), random)
    return Effect('flattened', {'share': share}, 'of the width', {'flattened': share})


def combed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much a beam that scans to and fro is told off on its way back."""
    shift = signed(_MOVES[size] / _PIXEL, random)
    return Effect('combed', {'shift': shift}, 'px', {'combed': shift})


TWENTYFIRST_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (flattened, combed)
}
