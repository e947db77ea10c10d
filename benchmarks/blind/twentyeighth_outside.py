# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-eighth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup

_MITRED = (4.0, 8.0, 20.0)  # Of one side of the end; amid it, half of that [mm].
_MOVES = (0.002, 0.004, 0.010)  # Of what is seen to the side [m].


def mitred(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how far aslant the wall stood that closed a mould at the tip."""
    changes = {
        'mitred': number(_MITRED[size], random),
        'mitred_side': float(random.choice([-1.0, 1.0])),
    }
    amplitude: dict[str, float | str] = {
        'shorter': changes['mitred'],
        'side': changes['mitred_side'],
    }
    return Effect('mitred', amplitude, 'mm, of y', changes)


def lapsed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw after which row a cable loses bytes of each image, and how many columns that is."""
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    middle = setup.shape.place(np.array([[0.6 * setup.shape.length, 0.0, 0.0]]))
    world = setup.depth_from_world @ setup.observations[0].world_from_object
    row = float(setup.camera.project(applied(world, middle))[0, 1]) + random.uniform(-12.0, 12.0)
    changes = {
        'lapsed': signed(_MOVES[size] * setup.camera.fx / distance, random),
        'lapsed_row': round(row),
    }
    amplitude: dict[str, float | str] = {
        'shift': changes['lapsed'],
        'row': changes['lapsed_row'],
    }
    return Effect('lapsed', amplitude, 'px, row of the image', changes)


TWENTYEIGHTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (mitred, lapsed)}
