# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms that the set of motions `swings_two` alone has.

Half of them show over time alone, the others at rest as well. Their second and third size change
what is seen by some 4 and 9 mm at its largest, where the mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import number, signed, weight_moment
from benchmarks.blind.form import Form
from benchmarks.blind.setups import Setup
from benchmarks.blind.swing_set_forms import area_by_mass
from benchmarks.blind.swing_set_outside import first_sag
from benchmarks.blind.timing import PERIOD

_ASKED = (5, 2, 1)  # Whole times that a driver asks for an image between two frames.


def _polled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a driver that asks for images: never once for each, or all would wait as long."""
    step = 1e3 * PERIOD / (_ASKED[size] + float(random.uniform(0.3, 0.7)))
    return {
        'stamps_form': 'polled',
        'stamps_late': round(0.5 * step, 5),
        'stamps_asked': round(float(random.uniform(0.0, 1.0)), 4),
    }


def _set_over(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a computer that comes by the right time some frames after the release."""
    return {
        'stamps_form': 'set over',
        'stamps_late': signed((2.5, 6.0, 12.0)[size], random),
        'stamps_set': int(random.integers(9, 13)),
    }


def _cup(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'drag_form': 'cup',
        'drag_area': area_by_mass((8.0, 35.0, 85.0)[size], setup, random),
        'drag_at': round(float(random.uniform(0.7, 0.95)), 3),
        'drag_mouth': float(random.choice([-1.0, 1.0])),
    }


def _root(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a glassy rubber's creep (Kohlrausch 1854, Ann. Phys. 167)."""
    return {
        'creep_form': 'root',
        'creep_share': number((0.1, 0.2, 0.38)[size], random),
        'creep_time': round(float(random.uniform(4.0, 12.0)), 2),
    }


def _edge_chain(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    mass, _ = weight_moment(setup)
    begun = round(float(random.uniform(0.3, 0.5)), 3)
    # On an even bar, what is spread from two fifths on moves the end by three halves of its share
    # of the mass, times the sag, twice as far in a swing.
    share = (0.0012, 0.0025, 0.005)[size] / (3.0 * first_sag(setup))
    return {
        'chain_mass': number(1e3 * mass * share, random),
        'chain_from': begun,
        'chain_side': float(random.choice([-1.0, 1.0])),
    }


def _boot(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw what a rigid body would turn in it; one that is soft there turns by more."""
    _, moment = weight_moment(setup)
    by_turn = float(np.deg2rad((0.04, 0.08, 0.18)[size])) / moment
    return {'clamp_form': 'boot', 'clamp_compliance': number(by_turn, random)}


def _swaying(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a table on air: it sways mostly about the way along which the body lies."""
    most = (3.0, 7.0, 15.0)[size]
    return {
        'tilt_form': 'swaying',
        'gravity_tilt': (signed(most, random), signed(0.3 * most, random)),
        'tilt_rate': round(float(random.uniform(1.0, 1.6)), 4),
        # It is on its way over as the body is let go, and still far out a quarter later.
        'tilt_phase': round(float(random.uniform(0.2, 0.8)), 4),
    }


def _switched_on(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'depth_form': 'switched on',
        'depth_bias': signed((1.5, 4.0, 9.0)[size], random),
        'depth_time': round(float(random.uniform(10.0, 22.0)), 2),
    }


SWINGS_TWO_FORMS = (
    Form('time_offset', 'polled', _polled),
    Form('time_offset', 'set over', _set_over),
    Form('air_drag', 'cup', _cup),
    Form('creep', 'root', _root),
    Form('added_mass', 'edge chain', _edge_chain),
    Form('compliant_clamp', 'boot', _boot),
    Form('gravity_tilt', 'swaying', _swaying),
    Form('depth_affine', 'switched on', _switched_on),
)
