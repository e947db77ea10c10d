# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the seventeenth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray, hollowing
from benchmarks.blind.slender import even_sag, SHARES, softness

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_DISHED = 0.45  # Share of the height that is lacking; less is left of what would fall apart.


def dished(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how hollow a body's upper side is, which climbed up the walls of an open mould."""
    shares = np.linspace(0.0, _MOST_DISHED, 46)
    changes = [even_sag(setup) * (_sag(setup, share) - 1.0) for share in shares]
    share = number(float(np.interp(_MOVES[size], changes, shares)), random)
    return Effect('dished', {'share': share}, 'of the height', {'dished': share})


def _sag(setup: Setup, share: float) -> float:
    """Return how far a tip of a dished body sinks by its weight, over that of a full one."""
    across = np.asarray((np.arange(100) + 0.5) / 50.0 - 1.0, dtype=np.float64)
    # Of the section's thickness, from its lower side.
    thick = 1.0 - share * hollowing(SHARES[:, None], across)
    area, first, second = (_mean(thick**power / power) for power in (1, 2, 3))
    softer = 1.0 / (12.0 * (second - first**2 / area))
    # The moment at a place is that of all the weight beyond it.
    beyond = np.maximum(SHARES - SHARES[:, None], 0.0)
    parts = (1.0 - SHARES) * softness(setup)
    return float((beyond @ area) * softer @ parts / (beyond.sum(axis=1) @ parts))


def _mean(values: FloatArray) -> FloatArray:
    """Return means over the width, at `SHARES`."""
    return np.asarray(values.mean(axis=1))


def fattened(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how wide the blocks are that a stereo pair matches, over an outline."""
    radius = number((3.0, 7.0, 17.0)[size], random)
    return Effect('fattened', {'radius': radius}, 'px', {'fattened': radius})


SEVENTEENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (dished, fattened)}
