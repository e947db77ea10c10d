# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the set of motions `swings` has: they show only in a motion."""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, weight_moment
from benchmarks.blind.laying import softer
from benchmarks.blind.setups import GRAVITY, Setup

# What a case that moves makes of a drawn modulus.
SOFTER = 0.6
_FIRST_MODE = 3.516  # Of an even bar that is held at one end.


def first_rate(setup: Setup) -> float:
    """Return about how fast a drawn body will swing [rad/s]."""
    shape, modulus = setup.shape, softer(setup, SOFTER).youngs_modulus
    free = shape.length - shape.clamp
    stiffness = modulus * min(shape.section) ** 2 / (12.0 * setup.density)
    return float(_FIRST_MODE * np.sqrt(stiffness) / free**2)


def first_sag(setup: Setup) -> float:
    """Return about how far the end of a drawn body will sag at rest [m]."""
    # A waist is as narrow as that where a body bends most of what it does beyond its root.
    even = _FIRST_MODE**2 / 8.0 * GRAVITY / first_rate(setup) ** 2
    return float(even / (1.0 - setup.shape.waist) ** 3)


def shaken(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the shaking of a rig that stands beside a machine; the camera stands elsewhere."""
    amount = number((0.5, 1.0, 2.0)[size], random)
    rate = round(first_rate(setup) / (2.0 * np.pi) * float(random.uniform(1.5, 2.0)), 3)
    angle = random.uniform(0.0, 2.0 * np.pi)
    way = (0.0, round(float(np.cos(angle)), 6), round(float(np.sin(angle)), 6))
    return Effect(
        'shaken',
        {'amplitude': amount, 'rate': rate},
        'mm, Hz',
        {
            'shaken': amount,
            'shaken_rate': rate,
            'shaken_phase': round(float(random.uniform(0.0, 2.0 * np.pi)), 4),
            'shaken_way': way,
        },
    )


def kicked(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the impulse of a ledge that snaps away: across the body, or up and down where wide."""
    mass, _ = weight_moment(setup)
    move = (0.0015, 0.003, 0.0055)[size]
    # A fourth of an even bar's mass goes with its end.
    impulse = move * first_rate(setup) * 0.25 * mass * float(random.uniform(0.85, 1.15))
    width, height = setup.shape.section
    slant = np.deg2rad(random.uniform(-20.0, 20.0))
    if width < 2.0 * height:
        slant += 0.25 * np.pi * float(random.choice([-1.0, 1.0]))
    side = float(random.choice([-1.0, 1.0]))
    way = (0.0, round(float(np.sin(slant)), 6), round(side * float(np.cos(slant)), 6))
    impulse = float(f'{impulse:.5g}')
    return Effect('kicked', {'impulse': impulse}, 'N s', {'kicked': impulse, 'kicked_way': way})


SWING_SET_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (shaken, kicked)}
