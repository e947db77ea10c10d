# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twelfth set alone has.

Their second and third size change what is seen of a body by some 5 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.outside_forms import tip_sag, tip_stiffness
from benchmarks.blind.setups import Setup

_MOST_BORNE = 0.75  # Of the sag that lines take away.


def guy(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw lines from a post above the clamp, which bear the body where it sags away from it."""
    shape = setup.shape
    sag = tip_sag(setup)
    lift = min((0.002, 0.005, 0.010)[size], _MOST_BORNE * sag)
    at = round(float(random.uniform(0.6, 0.85)), 4)
    high = round(float(random.uniform(50.0, 70.0)), 3)
    upward = np.sin(np.arctan2(1e-3 * high, at * (shape.length - shape.clamp)))
    # What a line bears at its place it takes from the sag there.
    across = lift / (sag - lift) * tip_stiffness(setup) / at**3
    stiffness = number(across / upward**2, random)
    post = (round(1e3 * shape.clamp, 3), 0.0, high)
    amplitude: dict[str, float | str] = {'stiffness': stiffness, 'at': at, 'z': high}
    changes = {'guy': stiffness, 'guy_at': at, 'guy_post': post}
    return Effect('guy', amplitude, 'N/m, of the free length, mm', changes)


def drawn(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much a body was drawn longer when it was taken out of its mould too early."""
    free = setup.shape.length - setup.shape.clamp
    share = number((0.0016, 0.004, 0.008)[size] / free, random)
    return Effect('drawn', {'share': share}, 'of the free length', {'drawn': share})


TWELFTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (guy, drawn)}
