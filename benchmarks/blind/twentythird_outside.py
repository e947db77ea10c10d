# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-third set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm, where the mechanics
allow it.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.004, 0.010)  # Of what is seen of a body [m].
_MOST_SLOPING = 0.55  # Of the height, by which an upper side is higher at one side.


def unlevel(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how far from level an open mould stood, which the stated body does not."""
    most = _MOST_SLOPING * min(_MOVES[2] / (_MOST_SLOPING * setup.shape.section[1]), 1.0)
    share = signed(most * _MOVES[size] / _MOVES[2], random)
    return Effect('unlevel', {'share': share}, 'of the height', {'unlevel': share})


def flicker(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw bands of light from a lamp on the mains, which a rolling shutter makes of its flicker.

    They stand in a pose, as frames keep time with the mains.
    """
    most, period = number((2.0, 4.0, 10.0)[size], random), random.uniform(50.0, 130.0)
    phases = random.uniform(0.0, 2.0 * np.pi, len(setup.observations))
    changes = {
        'flicker': most,
        'flicker_period': round(float(period), 3),
        'flicker_phases': tuple(round(float(phase), 4) for phase in phases),
    }
    told = {f'phase_{number}': phase for number, phase in enumerate(changes['flicker_phases'])}
    amplitude = {'amplitude': most, 'period': changes['flicker_period'], **told}
    return Effect('flicker', amplitude, 'mm, px, rad', changes)


TWENTYTHIRD_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (unlevel, flicker)}
