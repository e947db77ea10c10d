# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms that the set of motions `swings_five` alone has.

All but creep are the same at all times. Their second and third size change what is seen by some 4
and 9 mm at its largest, where the mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import number, signed, weight_moment
from benchmarks.blind.form import Form
from benchmarks.blind.setups import Setup
from benchmarks.blind.swing_set_forms import area_by_mass
from benchmarks.blind.swing_set_outside import first_sag
from benchmarks.blind.swings_three_forms import by_width

_SAGS = 0.025  # At rest: what sags by less swings faster, and sooner gets out of step [m].


def _in_step(setup: Setup) -> float:
    """Return how much less it takes to move a body by as much, as it swings faster."""
    return min(first_sag(setup) / _SAGS, 1.0)


def _interlaced(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw half of the time between two passes: a stamp is that of the last, or of the first."""
    return {'stamps_form': 'interlaced', 'stamps_late': signed((1.8, 4.5, 10.0)[size], random)}


def _furred(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'drag_form': 'furred',
        'drag_area': area_by_mass(by_width(setup) * (8.0, 22.0, 55.0)[size], setup, random),
        'drag_at': round(float(random.uniform(0.45, 0.7)), 3),
    }


def _oiled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw oil that came in from all sides, mostly not as far as to the middle."""
    return {
        'creep_form': 'oiled',
        'creep_share': number((0.2, 0.42, 0.72)[size], random),
        'creep_time': round(float(random.uniform(4.0, 12.0)), 2),
        'creep_depth': round(500.0 * min(setup.shape.section) * random.uniform(0.3, 0.5), 4),
    }


def _bracket(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a bracket by what it would turn; its foot is farther away than the clamp's mouth."""
    _, moment = weight_moment(setup)
    by_turn = _in_step(setup) * float(np.deg2rad((0.18, 0.48, 1.05)[size])) / moment
    return {
        'clamp_form': 'bracket',
        'clamp_compliance': number(by_turn, random),
        'bracket_drop': round(float(random.uniform(10.0, 25.0)), 2),
    }


def _breeze(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw what blows mostly across the way along which a body lies."""
    most = (2.0, 5.0, 10.5)[size] * by_width(setup)
    return {
        'tilt_form': 'breeze',
        'gravity_tilt': (signed(most, random), signed(0.3 * most, random)),
        'breeze_speed': round(float(random.uniform(3.5, 5.5)), 3),
    }


def _pack(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    mass, _ = weight_moment(setup)
    middle, half = random.uniform(0.6, 0.72), random.uniform(0.12, 0.2)
    # On an even bar, what is about two thirds out moves the end by four thirds of its share of
    # the mass, times the sag, twice as far in a swing.
    share = (0.0015, 0.004, 0.009)[size] / (8.0 / 3.0 * first_sag(setup))
    # One that tapers is lighter there, and gives way by more.
    share *= _in_step(setup) * (1.0 - setup.shape.taper[0])
    return {
        'pack_mass': number(1e3 * mass * share, random),
        'pack_from': round(float(middle - half), 3),
        'pack_until': round(float(middle + half), 3),
    }


def _frothed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    more = (0.0015, 0.004, 0.009)[size] / first_sag(setup)
    # On an even bar about half of what bubbles are at most counts; a swing goes twice as far.
    return {
        'contrast_mode': 'frothed',
        'contrast': -number(0.9 * float(np.sqrt(by_width(setup))) * more, random),
    }


def _dented(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    across, down = random.uniform(-70.0, 70.0), random.uniform(-40.0, 40.0)
    return {
        'depth_form': 'dented window',
        'depth_bias': signed((1.5, 4.0, 9.0)[size], random),
        'depth_spot': (round(float(across), 2), round(float(down), 2)),
        'depth_width': round(float(random.uniform(130.0, 210.0)), 2),
    }


SWINGS_FIVE_FORMS = (
    Form('time_offset', 'interlaced', _interlaced),
    Form('air_drag', 'furred', _furred),
    Form('creep', 'oiled', _oiled),
    Form('compliant_clamp', 'bracket', _bracket),
    Form('gravity_tilt', 'breeze', _breeze),
    Form('added_mass', 'pack', _pack),
    Form('stiffness_contrast', 'frothed', _frothed),
    Form('depth_affine', 'dented window', _dented),
)
