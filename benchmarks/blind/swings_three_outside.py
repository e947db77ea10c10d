# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library of the set `swings_three`: they show only in a motion."""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, weight_moment
from benchmarks.blind.setups import GRAVITY, Setup


def gust(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a gust across a body's broad side, a while after the release."""
    mass, _ = weight_moment(setup)
    most = float(f'{number((0.06, 0.13, 0.28)[size], random) * mass * GRAVITY:.5g}')
    width, height = setup.shape.section
    slant = np.deg2rad(random.uniform(-20.0, 20.0))
    if width < 2.0 * height:
        slant += np.deg2rad(random.uniform(30.0, 70.0)) * float(random.choice([-1.0, 1.0]))
    side = float(random.choice([-1.0, 1.0]))
    way = (0.0, round(float(np.sin(slant)), 6), round(side * float(np.cos(slant)), 6))
    begun, lasts = (round(float(random.uniform(*ends)), 4) for ends in ((0.04, 0.1), (0.1, 0.16)))
    return Effect(
        'gust',
        {'most': most, 'begins': begun, 'lasts': lasts},
        'N, s, s',
        {'gust': most, 'gust_from': begun, 'gust_time': lasts, 'gust_way': way},
    )


def rippled(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a sensor that throws fringes one after another on what it sees."""
    amount = number((3.5, 8.0, 18.0)[size], random)
    period = round(float(random.uniform(28.0, 45.0)), 2)
    return Effect(
        'rippled',
        {'depth_over_rate': amount, 'period': period},
        'ms, px',
        {
            'rippled': amount,
            'ripple_period': period,
            'ripple_phase': round(float(random.uniform(0.0, 2.0 * np.pi)), 4),
        },
    )


SWINGS_THREE_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (gust, rippled)}
