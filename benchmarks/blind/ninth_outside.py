# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the ninth set alone has.

Their second and third size change what is seen of a body by some 5 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup


def bath(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much a liquid bears, and how high it stands around the body's middle."""
    share = number((0.1, 0.3, 0.75)[size], random)
    shape = setup.shape
    middle = shape.place(np.array([[0.5 * (shape.clamp + shape.length), 0.0, 0.0]]))
    high = float(applied(setup.observations[0].world_from_object, middle)[0, 1])
    level = round(high + float(random.uniform(-0.002, 0.006)), 5)
    amplitude: dict[str, float | str] = {'share': share, 'level': level}
    return Effect('bath', amplitude, 'of the weight, m', {'bath': share, 'bath_level': level})


def trimmed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much was cut off at the tip, of a crossbar not all."""
    last, end = setup.shape.breaks[0][-2:]
    length = min(number((2.0, 5.0, 10.0)[size], random), round(800.0 * (end - last), 3))
    return Effect('trimmed', {'length': length}, 'mm', {'trimmed': length})


def fabric(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how stiff a fabric in the upper side is, which is slack where it is not drawn."""
    share = number((0.7, 2.0, 8.0)[size], random)
    return Effect('fabric', {'share': share}, 'of E', {'fabric': share})


def wobble(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how far a scanning mirror swings aside from row to row."""
    amount = number((4.0, 9.0, 18.0)[size], random)
    period = round(float(random.uniform(120.0, 240.0)), 3)
    phase = round(float(random.uniform(0.0, 2.0 * np.pi)), 4)
    changes = {'wobble': amount, 'wobble_period': period, 'wobble_phase': phase}
    amplitude: dict[str, float | str] = {'amount': amount, 'period': period, 'phase': phase}
    return Effect('wobble', amplitude, 'px, px, rad', changes)


NINTH_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (bath, trimmed, fabric, wobble)
}
