# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirteenth set alone has.

Their second and third size change what is seen of a body by some 5 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.outside_forms import tip_sag
from benchmarks.blind.setups import Setup

_MOST_CRAZED = 0.75  # Share of E that cracks take.


def crazed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how deep the cracks of an aged upper side are, which open where that is drawn."""
    # Per half height: area, first and second moment of the section with a softer upper quarter.
    shares = np.linspace(0.0, _MOST_CRAZED, 101)
    area, first, second = 2.0 - 0.5 * shares, -0.375 * shares, 2 / 3 - 0.875 / 3 * shares
    sags = tip_sag(setup) * (2 / 3 / (second - first**2 / area) - 1.0)
    wanted = float(np.interp((0.002, 0.004, 0.008)[size], sags, shares))
    share = number(wanted, random)
    return Effect('crazed', {'share': share}, 'of E', {'crazed': share})


def skewed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much each line of an image begins later than the one above it."""
    slope = signed((0.035, 0.09, 0.18)[size], random)
    return Effect('skewed', {'slope': slope}, 'columns over rows', {'skewed': slope})


THIRTEENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (crazed, skewed)}
