# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-fourth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm, where the mechanics
allow it.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.004, 0.010)  # Of what is seen of a body [m].
_MOST_FLARED = 0.55  # Share by which a body is wider at its upper side.


def drafted(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much a mould's walls flare, so that a body comes out, which the stated do not."""
    most = min(_MOVES[2] / (0.5 * setup.shape.section[0]), _MOST_FLARED)
    share = signed(most * _MOVES[size] / _MOVES[2], random)
    return Effect('drafted', {'share': share}, 'of the width', {'drafted': share})


def blocky(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the squares of which a codec that saves its bits keeps the mean alone."""
    edge = round(number((5.0, 10.0, 32.0)[size], random))
    return Effect('blocky', {'edge': edge}, 'px', {'blocky': edge})


TWENTYFOURTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (drafted, blocky)}
