# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the fifteenth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.outside_forms import tip_sag, tip_stiffness
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import necking

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_NECKED = 0.55  # Share of a section; less is left of what would be torn off.


def magnetized(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how strongly a body of magnetized rubber is turned to a field across the bench."""
    # More across than up: what is drawn up or down is as if it were lighter or heavier.
    angle = float(random.choice([0.0, np.pi])) + np.deg2rad(random.uniform(-35.0, 35.0))
    way = (0.0, round(float(np.sin(angle)), 6), round(float(np.cos(angle)), 6))
    width, height = setup.shape.section
    # The moments of an even field on an even body are those of a force on its end. More than the
    # formula asks: in most poses a part of it goes along the body.
    density = number(1.25 * _MOVES[size] * tip_stiffness(setup) / (width * height), random)
    changes = {'magnetized': density, 'magnetic_way': way}
    amplitude: dict[str, float | str] = {'density': density, 'y': way[1], 'z': way[2]}
    return Effect('magnetized', amplitude, 'J/m^3', changes)


def necked(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much thinner a body is where it was drawn out of its mould by force."""
    at = round(float(random.uniform(0.15, 0.3)), 4)
    depths, shares = np.linspace(0.0, _MOST_NECKED, 101), (np.arange(200) + 0.5) / 200.0
    # By the tip's share of an even load's moments, (1 - share)^3, a part is softer.
    softer = (1.0 - depths[:, None] * necking(shares, at)) ** -4.0
    changes = tip_sag(setup) * (softer @ (1.0 - shares) ** 3 / 50.0 - 1.0)
    share = number(float(np.interp(_MOVES[size], changes, depths)), random)
    amplitude: dict[str, float | str] = {'share': share, 'at': at}
    changed = {'necked': share, 'necked_at': at}
    return Effect('necked', amplitude, 'of the section, of the free length', changed)


FIFTEENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (magnetized, necked)}
