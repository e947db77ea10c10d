# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms that the set of motions `swings_four` alone has.

Half of them show over time alone, the others at rest as well. Their second and third size change
what is seen by some 4 and 9 mm at its largest, where the mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed, weight_moment
from benchmarks.blind.form import Form
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.swing_set_forms import area_by_mass
from benchmarks.blind.swing_set_outside import first_sag
from benchmarks.blind.swings_three_forms import by_width


def _swept(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw half of the time of a sweep: a stamp is that of its end, or of its beginning."""
    return {'stamps_form': 'swept', 'stamps_late': signed((2.5, 6.0, 13.0)[size], random)}


def _tuft(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'drag_form': 'tuft',
        'drag_area': area_by_mass((8.0, 28.0, 78.0)[size], setup, random),
        'drag_at': round(float(random.uniform(0.7, 0.95)), 3),
        'drag_bends': round(float(random.uniform(0.25, 0.45)), 4),
    }


def _setting(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a rubber that is loaded before it is through: what it gives way by is there to stay."""
    return {
        'creep_form': 'setting',
        'creep_share': number((0.12, 0.27, 0.47)[size], random),
        'creep_time': round(float(random.uniform(4.0, 7.0)), 2),
        'creep_set': round(float(random.uniform(6.0, 10.0)), 2),
    }


def _toppling(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a table with a short foot: it topples mostly about the way along which a body lies."""
    most = (3.0, 7.0, 15.0)[size]
    return {
        'tilt_form': 'toppling',
        'gravity_tilt': (signed(most, random), signed(0.3 * most, random)),
        'tilt_time': round(float(random.uniform(0.05, 0.1)), 4),
        'tilt_fall': round(float(random.uniform(0.12, 0.2)), 4),
    }


def _gel(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw what a rigid body would turn in it at last."""
    _, moment = weight_moment(setup)
    by_turn = float(np.deg2rad((0.02, 0.055, 0.17)[size])) / moment
    return {
        'clamp_form': 'gel',
        'clamp_compliance': number(by_turn, random),
        'clamp_time': round(float(random.uniform(0.02, 0.05)), 4),
    }


def _balls(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw rubber balls, so soft that a body swings on with them."""
    mass, _ = weight_moment(setup)
    sag = first_sag(setup)
    bar = 3.0 / 8.0 * mass * GRAVITY / sag
    # A body at rest flattens them by less than its sag, and one that swings by more.
    amount = (0.1, 0.3, 0.8)[size] * by_width(setup) ** 2 * bar / float(np.sqrt(sag))
    return {
        'balls': float(f'{number(amount, random):.5g}'),
        'balls_from': round(float(random.uniform(0.6, 0.8)), 3),
        'balls_top': round(float(random.uniform(0.6, 0.8)), 3),
    }


def _unrolling(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a bend by about how far it moves the end, which then weighs less far from the clamp."""
    free = setup.shape.length - setup.shape.clamp
    curvature = 3.0 * (0.0015, 0.004, 0.009)[size] / free**2
    return {
        'curvature_form': 'unrolling',
        'rest_curvature': direction(curvature, 2, random),
        'curvature_time': round(float(random.uniform(4.0, 10.0)), 2),
    }


def _in_turn(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a sensor with a long and a short exposure in turn, one of which is not calibrated."""
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    return {
        'depth_form': 'in turn',
        'depth_scale': signed(100.0 * (0.0015, 0.004, 0.009)[size] / distance, random),
        'depth_turn': int(random.integers(2)),
    }


SWINGS_FOUR_FORMS = (
    Form('time_offset', 'swept', _swept),
    Form('air_drag', 'tuft', _tuft),
    Form('creep', 'setting', _setting),
    Form('gravity_tilt', 'toppling', _toppling),
    Form('compliant_clamp', 'gel', _gel),
    Form('contact_plane', 'balls', _balls),
    Form('rest_curvature', 'unrolling', _unrolling),
    Form('depth_affine', 'in turn', _in_turn),
)
