# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms that the set of motions `swings_three` alone has.

Half of them show over time alone, the others at rest as well. Their second and third size change
what is seen by some 4 and 9 mm at its largest, where the mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import number, signed, weight_moment
from benchmarks.blind.form import Form
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.swing_set_forms import area_by_mass
from benchmarks.blind.swing_set_outside import first_sag


def by_width(setup: Setup) -> float:
    """Return how much more it takes on a body that is flat: aslant, it swings half as far."""
    width, height = setup.shape.section
    return 1.8 if width > 2.0 * height else 1.0


def _stalled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a computer that did something else while a body swings."""
    return {
        'stamps_form': 'stalled',
        'stamps_late': number((3.5, 8.0, 17.0)[size], random),
        'stamps_stall': int(random.integers(7, 10)),
        'stamps_drain': round(float(random.uniform(3.5, 5.5)), 3),
    }


def _smoothed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a driver's filter: the largest is what a driver has from the first."""
    return {'smoothing': number((0.18, 0.35, 0.6)[size], random)}


def _vane(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'drag_form': 'vane',
        'drag_area': area_by_mass(by_width(setup) * (8.0, 36.0, 85.0)[size], setup, random),
        'drag_at': round(float(random.uniform(0.7, 0.95)), 3),
        'drag_slant': round(float(random.choice([-1.0, 1.0]) * random.uniform(30.0, 50.0)), 2),
    }


def _warmed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a lamp that is switched on with the load: a cool body hardly creeps."""
    return {
        'creep_form': 'warmed',
        'creep_share': number((0.1, 0.24, 0.45)[size], random),
        'creep_time': round(float(random.uniform(60.0, 100.0)), 1),
        'creep_haste': round(float(random.uniform(9.0, 15.0)), 2),
        'creep_warmth': round(float(random.uniform(7.0, 13.0)), 2),
    }


def _leaking(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    mass, _ = weight_moment(setup)
    # On an even bar, what is at its end moves that by eight thirds of its share of the mass,
    # times the sag.
    share = (0.002, 0.005, 0.011)[size] / (8.0 / 3.0 * first_sag(setup))
    return {
        'leak_mass': number(1e3 * mass * share, random),
        'leak_at': round(float(random.uniform(0.7, 0.95)), 3),
        'leak_time': round(float(random.uniform(18.0, 45.0)), 2),
    }


def _putty(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw what a rigid body would turn in it at first."""
    _, moment = weight_moment(setup)
    degrees = (0.015, 0.04, 0.13)[size]
    by_turn = number(float(np.deg2rad(degrees)) / moment, random)
    # It bears many times the weight's moment in all, but most of that comes to its mouth alone.
    arm = 0.3 * setup.shape.clamp
    give = float(random.uniform(15.0, 20.0)) * by_turn * moment * arm
    return {
        'clamp_form': 'putty',
        'clamp_compliance': by_turn,
        'putty_give': float(f'{1e3 * give:.5g}'),
    }


def _drooping(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a ball head that was closed as the filming began: the camera looks ever lower."""
    turn = number((0.2, 0.5, 1.1)[size], random)
    return {
        'camera_turn': (-turn, signed(0.15 * turn, random), signed(0.3 * turn, random)),
        'camera_foot': (0.0, round(float(random.uniform(0.04, 0.07)), 4), 0.0),
        'camera_hold': round(float(random.uniform(1.5, 5.0)), 3),
    }


def _wadding(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a heap of cotton wool, so soft that a body swings on in it."""
    mass, _ = weight_moment(setup)
    bar = 3.0 / 8.0 * mass * GRAVITY / first_sag(setup)
    return {
        'wool': number((0.02, 0.055, 0.14)[size] * bar * by_width(setup), random),
        'wool_from': round(float(random.uniform(0.65, 0.8)), 3),
        'wool_top': round(float(random.uniform(0.6, 0.8)), 3),
        'wool_floor': round(float(random.uniform(2.2, 2.6)), 3),
    }


SWINGS_THREE_FORMS = (
    Form('time_offset', 'stalled', _stalled),
    Form('time_offset', 'smoothed', _smoothed),
    Form('air_drag', 'vane', _vane),
    Form('creep', 'warmed', _warmed),
    Form('added_mass', 'leaking', _leaking),
    Form('compliant_clamp', 'putty', _putty),
    Form('camera_offset', 'drooping', _drooping),
    Form('contact_plane', 'wadding', _wadding),
)
