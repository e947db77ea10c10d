# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the eighth set alone has."""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.setups import Setup


def hose(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a hose from the rig to a place, which it would have a centimetre beside itself."""
    at = round(float(random.uniform(0.5, 0.75)), 4)
    # A share of what the body resists with at that place.
    stiffness = number((0.05, 0.15, 0.45)[size] * tip_stiffness(setup) / at**3, random)
    angle, away = random.uniform(0.0, 2.0 * np.pi), random.uniform(6.0, 10.0)
    y, z = (round(float(away * part), 3) for part in (np.cos(angle), np.sin(angle)))
    changes = {'hose': stiffness, 'hose_at': at, 'hose_offset': (0.0, y, z)}
    amplitude: dict[str, float | str] = {'stiffness': stiffness, 'at': at, 'y': y, 'z': z}
    return Effect('hose', amplitude, 'N/m, of the free length, mm', changes)


def parted(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much a body is higher whose mould's halves did not close."""
    share = number((0.03, 0.07, 0.15)[size], random)
    return Effect('parted', {'share': share}, 'of the height', {'parted': share})


def memory(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much of the load of the pose before a body still rests under."""
    share = number((0.05, 0.12, 0.3)[size], random)
    return Effect('memory', {'share': share}, 'of the load before', {'memory': share})


def tiles(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw an error of depth that is another in each square of the image."""
    amount = number((1.0, 2.0, 5.0)[size], random)
    edge = int(random.integers(28, 49))
    seed = int(random.integers(0, 2**31))
    changes = {'tiles': amount, 'tiles_edge': edge, 'tiles_seed': seed}
    amplitude: dict[str, float | str] = {'amount': amount, 'edge': edge}
    return Effect('tiles', amplitude, 'mm, px', changes)


EIGHTH_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (hose, parted, memory, tiles)
}
