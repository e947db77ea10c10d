# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library of the set `swings_four`: they show only in a motion."""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, weight_moment
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.swing_set_outside import first_rate, first_sag
from benchmarks.blind.swings_three_forms import by_width


def remanent(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a magnet of a ledge that lets go slowly: it draws across a body's broad side."""
    mass, _ = weight_moment(setup)
    # By how stiff an even bar is under a load at its end.
    bar = 3.0 / 8.0 * mass * GRAVITY / first_sag(setup)
    most = float(f'{number((0.0015, 0.004, 0.009)[size], random) * bar:.5g}')
    width, height = setup.shape.section
    slant = np.deg2rad(random.uniform(-20.0, 20.0))
    if width < 2.0 * height:
        slant += np.deg2rad(random.uniform(30.0, 70.0)) * float(random.choice([-1.0, 1.0]))
    side = float(random.choice([-1.0, 1.0]))
    way = (0.0, round(float(np.sin(slant)), 6), round(side * float(np.cos(slant)), 6))
    lasts = round(float(random.uniform(0.08, 0.16)), 4)
    return Effect(
        'remanent',
        {'most': most, 'lasts': lasts},
        'N, s',
        {'remanent': most, 'remanent_time': lasts, 'remanent_way': way},
    )


def tearing(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw small tears near the clamp, which come where a body first swings farthest down."""
    more = (0.0015, 0.004, 0.009)[size] / first_sag(setup)
    softer = round(float(np.log1p(5.0 * by_width(setup) * more * random.uniform(0.85, 1.15))), 5)
    at = round(float(random.uniform(0.08, 0.2)), 3)
    half = np.pi / first_rate(setup)
    when = round(float(half * random.uniform(0.8, 1.0)), 4)
    return Effect(
        'tearing',
        {'log_ratio': -softer, 'at': at, 'when': when},
        'log E, share of the free length, s',
        {'tearing': softer, 'tearing_at': at, 'tearing_time': when},
    )


SWINGS_FOUR_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (remanent, tearing)
}
