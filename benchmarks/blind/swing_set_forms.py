# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms that the set of motions `swings` alone has: what clocks, air, rubber and rigs really do.

Their second and third size change what is seen by some 4 and 9 mm at its largest, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import number, signed, weight_moment
from benchmarks.blind.form import Form
from benchmarks.blind.setups import Setup
from benchmarks.blind.stamping import QUEUE
from benchmarks.blind.swing_set_outside import first_sag

_WAIT = (2.0, 5.5, 11.0)  # Late, on average [ms].
_HALF_READ = (2.5, 6.0, 13.0)  # Half a readout, or half an exposure [ms].


def _backlog(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a queue between driver and recorder: a wait is never negative."""
    return {
        'stamps_form': 'backlog',
        'stamps_late': number(_WAIT[size], random),
        # The first frame is not one that is dropped.
        'stamps_phase': int(random.integers(QUEUE - 1)),
    }


def _over_time(name: str) -> Form:
    """Return a frame that takes its time: its stamp is that of the end, or of the beginning."""

    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        return {'stamps_form': name, 'stamps_late': signed(_HALF_READ[size], random)}

    return Form('time_offset', name, draw)


def area_by_mass(amount: float, setup: Setup, random: np.random.Generator) -> float:
    """Draw drag coefficient times area [cm^2] by the mass that the air slows down [cm^2/g]."""
    mass, _ = weight_moment(setup)
    return number(1e3 * mass * amount, random)


def _laminar(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'drag_form': 'laminar',
        'drag_area': area_by_mass((10.0, 40.0, 90.0)[size], setup, random),
    }


def _sail(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'drag_form': 'sail',
        'drag_area': area_by_mass((6.0, 25.0, 60.0)[size], setup, random),
        'drag_at': round(float(random.uniform(0.7, 0.95)), 3),
    }


def _power(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw an open foam's creep, over decades of the time."""
    return {
        'creep_form': 'power',
        'creep_share': number((0.1, 0.22, 0.4)[size], random),
        'creep_time': round(float(random.uniform(0.3, 1.0)), 3),
        'creep_power': round(float(random.uniform(0.25, 0.45)), 3),
    }


def _flowing(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a rubber that was mixed with too little hardener: no network bears the load at last."""
    return {
        'creep_form': 'flowing',
        'creep_share': 1.0,
        'creep_time': number((500.0, 220.0, 100.0)[size], random),
    }


def _pour(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'creep_form': 'pour',
        'creep_share': number((0.1, 0.22, 0.4)[size], random),
        'creep_time': round(float(random.uniform(4.0, 12.0)), 2),
        'creep_until': round(float(random.uniform(0.35, 0.6)), 3),
    }


def _end_plate(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    mass, _ = weight_moment(setup)
    # On an even bar a plate moves the end by eight thirds of its share of the mass, times the sag,
    # twice as far in a swing.
    share = (0.002, 0.004, 0.008)[size] / (16.0 / 3.0 * first_sag(setup))
    return {'end_mass': number(1e3 * mass * share, random)}


def _yielding(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a table on soft feet: it leans mostly about the way along which the body lies."""
    most = (4.0, 10.0, 20.0)[size]
    return {
        'tilt_form': 'yielding',
        'gravity_tilt': (signed(most, random), signed(0.3 * most, random)),
        'tilt_time': round(float(random.uniform(0.03, 0.08)), 4),
    }


SWING_SET_FORMS = (
    Form('time_offset', 'backlog', _backlog),
    _over_time('rolling'),
    _over_time('exposed'),
    Form('air_drag', 'laminar', _laminar),
    Form('air_drag', 'sail', _sail),
    Form('creep', 'power', _power),
    Form('creep', 'flowing', _flowing),
    Form('creep', 'pour', _pour),
    Form('added_mass', 'end plate', _end_plate),
    Form('gravity_tilt', 'yielding', _yielding),
)
