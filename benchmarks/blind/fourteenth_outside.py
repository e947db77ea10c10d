# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the fourteenth set alone has.

Their second and third size change what is seen of a body by some 5 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.outside_forms import tip_sag
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup

_MOST_WORN = 0.7  # Share of E that a body can lose.
_WORN_PART = 0.9  # Of that, what it loses near its clamp, where it bends most.


def worn(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw which share of E a new body loses where it is strained for the first time."""
    sag = tip_sag(setup)
    # More than is asked of the largest: what is hardly strained loses little.
    lost = (1.0 - sag / (sag + (0.002, 0.005, 0.020)[size])) / _WORN_PART
    share = min(number(lost, random), _MOST_WORN)
    return Effect('worn', {'share': share}, 'of E', {'worn': share})


def clipped(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how far a sensor's least depth lies beyond the nearest place of a body's middle."""
    reach = number((1.0, 4.0, 10.0)[size], random)
    near = round(_nearest(setup), 5)
    amplitude: dict[str, float | str] = {'reach': reach, 'near': near}
    return Effect('clipped', amplitude, 'mm, m', {'clipped': reach, 'clipped_near': near})


def _nearest(setup: Setup) -> float:
    """Return the least depth of a body's middle line in all poses [m]."""
    ahead = np.linspace(setup.shape.clamp, setup.shape.length, 50)
    line = setup.shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0]))
    looks = (setup.depth_from_world @ pose.world_from_object for pose in setup.observations)
    return min(float(applied(look, line)[:, 2].min()) for look in looks)


FOURTEENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (worn, clipped)}
