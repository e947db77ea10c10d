# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the sixteenth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.faults import Faults
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import even_sag, levers, SHARES
from benchmarks.blind.whirl import whirled

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_WHIRLED = 1.1  # Of the weight, by which a whirl presses where it is strongest.


def whirl(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a ventilator above the bench, whose air turns about a place amid the body."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    ahead = shape.clamp + np.append(SHARES, random.uniform(0.35, 0.5)) * (
        shape.length - shape.clamp
    )
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    at = (round(float(places[-1, 0]), 5), round(float(places[-1, 2]), 5))
    radius = round(float(random.uniform(0.03, 0.05)), 4)
    felt = whirled(places[:-1], Faults(whirl=1.0, whirl_at=at, whirl_radius=radius))
    moved = even_sag(setup) * np.linalg.norm(levers(setup) @ felt) / len(SHARES)
    share = _MOVES[size] / float(moved)
    way = float(random.choice([-1.0, 1.0]))
    push = way * number(GRAVITY * min(share, _MOST_WHIRLED), random)
    changes = {'whirl': push, 'whirl_at': at, 'whirl_radius': radius}
    amplitude: dict[str, float | str] = {'push': push, 'x': at[0], 'z': at[1], 'radius': radius}
    return Effect('whirl', amplitude, 'm/s^2, m', changes)


def ghost(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much a sensor's filter over time still has of the pose before."""
    share = number((0.05, 0.12, 0.3)[size], random)
    return Effect('ghost', {'share': share}, 'of the depth before', {'ghost': share})


SIXTEENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (whirl, ghost)}
