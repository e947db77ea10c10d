# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirty-third set alone has.

It has their third size alone, which changes what is seen of a body by some 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.setups import Setup

_SIZES = (2.0, 4.0, 10.0)  # [mm].
_MOST_OFF = 0.8  # Share of half the height that may be planed off.


def bevelled(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much was planed off along one edge of a body's upper side."""
    most = 500.0 * _MOST_OFF * setup.shape.section[1] * (0.2, 0.5, 1.0)[size]
    off = min(number(_SIZES[size], random), round(most, 4))
    return Effect('bevelled', {'planed': off}, 'mm', {'bevelled': off})


def sawtoothed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw an error of a sensor whose strips of columns are read out one after another."""
    strip = round(float(random.uniform(50.0, 90.0)), 3)
    changes = {
        'sawtoothed': number(_SIZES[size], random),
        'sawtoothed_strip': strip,
        'sawtoothed_from': round(float(random.uniform(0.0, strip)), 3),
    }
    return Effect('sawtoothed', {'error': changes['sawtoothed']}, 'mm', changes)


def chirped(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw an error of a laser that is swept by a rate which is not the same all the time."""
    changes = {
        'chirped': number(_SIZES[size], random),
        'chirped_at': round(float(random.uniform(-60.0, 60.0)), 3),
        'chirped_wave': round(float(random.uniform(60.0, 85.0)), 3),
    }
    return Effect('chirped', {'error': changes['chirped']}, 'mm', changes)


THIRTYTHIRD_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (sawtoothed, chirped, bevelled)
}
