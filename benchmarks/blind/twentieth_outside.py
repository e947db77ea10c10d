# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twentieth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.faults import Faults
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import even_sag, levers, SHARES
from benchmarks.blind.updraught import updraught_push

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_BLOWN = 1.3  # Of the weight, by which air pushes up where it is strongest.


def updraught(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a fan that lies on the bench, and blows up against a level body's outer part."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    ahead = shape.clamp + np.append(SHARES, random.uniform(0.55, 0.8)) * (
        shape.length - shape.clamp
    )
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    at = (round(float(places[-1, 0]), 5), round(float(places[-1, 2]), 5))
    width = round(float(random.uniform(0.035, 0.05)), 4)
    stream = Faults(updraught=1.0, updraught_at=at, updraught_width=width)
    felt = updraught_push(places[:-1], stream)
    share = _MOVES[size] / (even_sag(setup) * float((levers(setup) * felt).mean()))
    push = number(GRAVITY * min(share, _MOST_BLOWN), random)
    changes = {'updraught': push, 'updraught_at': at, 'updraught_width': width}
    amplitude: dict[str, float | str] = {'push': push, 'x': at[0], 'z': at[1], 'width': width}
    return Effect('updraught', amplitude, 'm/s^2, m', changes)


def stuck(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw which bit of the depths is stuck that a sensor tells, by what it counts for."""
    worth = signed((2.0, 4.2, 10.5)[size], random)
    return Effect('stuck', {'worth': worth}, 'mm', {'stuck': worth})


TWENTIETH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (updraught, stuck)}
