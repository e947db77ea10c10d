# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirty-second set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.setups import Setup

_SIZES = (2.0, 4.0, 10.0)  # [mm].


def keeled(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how far a ridge stands out where the halves of a mould gaped on one side."""
    out = number(_SIZES[size], random)
    return Effect('keeled', {'ridge': out}, 'mm', {'keeled': out})


def spiralled(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw an error of depth of a mirror that scans along a spiral."""
    spot = random.uniform(-60.0, 60.0, 2)
    changes = {
        'spiralled': number(_SIZES[size], random),
        'spiralled_at': (round(float(spot[0]), 3), round(float(spot[1]), 3)),
        'spiralled_apart': round(float(random.uniform(40.0, 70.0)), 3),
    }
    return Effect('spiralled', {'error': changes['spiralled']}, 'mm', changes)


THIRTYSECOND_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (keeled, spiralled)
}
