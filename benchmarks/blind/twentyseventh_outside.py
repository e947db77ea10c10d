# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-seventh set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.setups import Setup

_JOGGLED = (2.0, 4.0, 10.0)  # Of the outer part [mm].
_MOIRE = (1.8, 3.6, 8.5)  # Amplitude of an error [mm].


def joggled(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how far the halves of a mould were out of line that were screwed together."""
    changes = {
        'joggled': number(_JOGGLED[size], random),
        'joggled_at': round(float(random.uniform(0.3, 0.55)), 4),
        'joggled_way': round(float(random.uniform(0.0, 360.0)), 3),
    }
    amplitude: dict[str, float | str] = {
        'far': changes['joggled'],
        'at': changes['joggled_at'],
        'way': changes['joggled_way'],
    }
    return Effect('joggled', amplitude, 'mm, share of the free length, deg', changes)


def moire(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the moire of a grid that is projected, and of the imager's own."""
    periods, phases = random.uniform(50.0, 90.0, 2), random.uniform(0.0, 2.0 * np.pi, 2)
    changes = {
        'moire': signed(_MOIRE[size], random),
        'moire_periods': tuple(round(float(period), 3) for period in periods),
        'moire_slant': round(float(random.uniform(10.0, 80.0)), 3),
        'moire_phases': tuple(round(float(phase), 4) for phase in phases),
    }
    amplitude: dict[str, float | str] = {
        'error': changes['moire'],
        'slant': changes['moire_slant'],
    }
    return Effect('moire', amplitude, 'mm, deg', changes)


TWENTYSEVENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (joggled, moire)}
