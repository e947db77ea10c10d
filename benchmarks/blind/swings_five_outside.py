# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library of the set `swings_five`: they show only in a motion."""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, weight_moment
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.swing_set_outside import first_sag


def rubbed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw two felts between which one place of a body moves, by what they hold it back with."""
    mass, _ = weight_moment(setup)
    at = round(float(random.uniform(0.75, 0.95)), 3)
    # By how stiff an even bar is under a load there: each half of a swing takes twice as much off
    # what is left of it.
    bar = 3.0 / 8.0 * mass * GRAVITY / first_sag(setup) / at**3
    most = float(f'{number(0.21 * (0.0015, 0.004, 0.009)[size], random) * bar:.5g}')
    return Effect(
        'rubbed',
        {'most': most, 'at': at},
        'N, share of the free length',
        {'rubbed': most, 'rubbed_at': at},
    )


def lurched(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the lurch of a stand, across the body; the camera stands elsewhere."""
    amount = number((0.8, 2.2, 4.9)[size], random)
    lasts = round(float(random.uniform(0.03, 0.06)), 4)
    angle = random.uniform(0.0, 2.0 * np.pi)
    way = (0.0, round(float(np.cos(angle)), 6), round(float(np.sin(angle)), 6))
    return Effect(
        'lurched',
        {'amplitude': amount, 'half': lasts},
        'mm, s',
        {'lurched': amount, 'lurched_time': lasts, 'lurched_way': way},
    )


SWINGS_FIVE_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (rubbed, lurched)}
