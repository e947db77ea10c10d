# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-sixth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm, where the mechanics
allow it.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.setups import Setup

_ROUNDED = (0.2, 0.4, 0.8)  # Share by which a section is round: more leaves its edges no angle.
_RINGS = (1.8, 3.6, 8.5)  # Amplitude of an error [mm].


def rounded(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how round a mould was, for which somebody took a pipe in place of a square channel."""
    changes = {'rounded': number(_ROUNDED[size], random)}
    return Effect('rounded', {'share': changes['rounded']}, '-', changes)


def rings(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the rings between a lens and a window that was pushed on too far."""
    across, down = random.uniform(-30.0, 30.0, 2)
    changes = {
        'rings': signed(_RINGS[size], random),
        'rings_at': (round(float(across), 3), round(float(down), 3)),
        'rings_radius': round(float(random.uniform(60.0, 90.0)), 3),
        'rings_phase': round(float(random.uniform(0.0, 2.0 * np.pi)), 4),
    }
    amplitude: dict[str, float | str] = {
        'error': changes['rings'],
        'radius': changes['rings_radius'],
        'phase': changes['rings_phase'],
    }
    return Effect('rings', amplitude, 'mm, px, rad', changes)


TWENTYSIXTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (rounded, rings)}
