# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library of the set of motions `swings_two`: they show only in a motion."""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed, weight_moment
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.swing_set_outside import first_sag

_ABOVE = 0.15  # From a body to the post of its leash [m].


def leash(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a rubber cord from the rig to a body, slack but where that swings far down."""
    mass, _ = weight_moment(setup)
    at, shape = round(float(random.uniform(0.75, 0.95)), 3), setup.shape
    # By how stiff an even bar is under a load there.
    bar = 3.0 / 8.0 * mass * GRAVITY / first_sag(setup) / at**3
    stiffness = number((0.12, 0.3, 0.8)[size] * bar, random)
    # A body at rest hangs free of it.
    taut = round(float(random.uniform(1.15, 1.35)), 3)
    along = shape.clamp + at * (shape.length - shape.clamp)
    up = setup.observations[0].world_from_object[1, :3]
    post = shape.place(np.array([[along, 0.0, 0.0]]))[0] + _ABOVE * up
    return Effect(
        'leash',
        {'stiffness': stiffness, 'taut': taut, 'at': at},
        'N/m, of the way to rest, share of the free length',
        {
            'leash': stiffness,
            'leash_at': at,
            'leash_post': tuple(round(1e3 * float(value), 3) for value in post),
            'leash_taut': taut,
        },
    )


def doppler(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a laser whose frequency is swept: what comes nearer beats at another one."""
    amount = signed((8.0, 18.0, 40.0)[size], random)
    return Effect('doppler', {'range_over_rate': amount}, 'ms', {'doppler': amount})


SWINGS_TWO_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (leash, doppler)}
