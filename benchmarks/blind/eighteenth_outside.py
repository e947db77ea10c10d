# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the eighteenth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m].


def shrinking(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much a body of gel is shorter at last, which dries as it is filmed."""
    free = setup.shape.length - setup.shape.clamp
    shorter = number(100.0 * _MOVES[size] / free, random)
    # Water comes out by the root of the time (Crank 1956, The Mathematics of Diffusion).
    through = np.arange(len(setup.observations)) / max(len(setup.observations) - 1, 1)
    shares = tuple(round(float(share), 4) for share in np.sqrt(through))
    told = {f'share_{pose}': share for pose, share in enumerate(shares)}
    changes = {'shrinking': shorter, 'shrinking_shares': shares}
    return Effect('shrinking', {'shorter': shorter, **told}, '%, of that by pose', changes)


def bleeding(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much of the background a filter mixes into the outline of a body."""
    amount = number((2.0, 4.2, 10.5)[size], random)
    width = round(float(random.uniform(5.0, 9.0)), 3)
    amplitude: dict[str, float | str] = {'amount': amount, 'width': width}
    changes = {'bleeding': amount, 'bleeding_width': width}
    return Effect('bleeding', amplitude, 'mm, px', changes)


EIGHTEENTH_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (shrinking, bleeding)
}
