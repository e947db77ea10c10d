# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the eleventh set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 5 and 10 mm.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.outside_forms import tip_sag, tip_stiffness
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.005, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_TILTED = 0.45  # Sine of the steepest floor.


def _recruited(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Fill a rubber with fibres that lie in waves, and bear once these are drawn straight."""
    return {
        'stiffening_form': 'recruited',
        'stiffening': number((0.2, 0.6, 2.0)[size], random),
        'stiffening_from': round(float(random.uniform(0.01, 0.03)), 4),
    }


def _slanted(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pour a second batch on a first one that set in a mould which stood aslant."""
    at = round(float(random.uniform(0.25, 0.45)), 4)
    contrasts = np.linspace(0.0, float(random.choice([-3.0, 3.0])), 101)
    # By the tip's share of an even load's moments, (1 - share)^3, a part is stiffer by exp(c).
    outer = (1.0 - at) ** 4
    sags = np.exp(0.5 * contrasts) * (1.0 - outer) + np.exp(-0.5 * contrasts) * outer
    contrast = np.interp(_MOVES[size], tip_sag(setup) * np.abs(sags - 1.0), contrasts)
    return {
        'contrast_mode': 'slanted',
        'contrast': number(float(contrast), random),
        'contrast_at': at,
        'contrast_slant': signed(0.17, random),
    }


def _loose(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a ring on a body that slides outward or inward in the steep poses."""
    at = round(float(random.uniform(0.5, 0.65)), 3)
    force = _MOVES[size] * tip_stiffness(setup) / (0.5 * at**2 * (3.0 - at))
    return {
        'mass_form': 'loose',
        'added_mass': number(1e3 * force / 9.81, random),
        'added_mass_at': at,
        'mass_stops': (
            round(float(random.uniform(0.15, 0.3)), 4),
            round(float(random.uniform(0.7, 0.8)), 4),
        ),
    }


def _glossy(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Dip the outer part in a gloss that errs most where it throws the light straight back."""
    return {
        'region_bias': signed((2.5, 6.0, 12.0)[size], random),
        'region_gloss': round(float(random.uniform(1.5, 3.5)), 3),
    }


def _jostled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Nudge a tripod on its floor whenever the body is turned, so that it walks away."""
    step, turn = ((0.8, 0.3), (2.0, 0.7), (4.5, 1.4))[size]
    walked, found = np.zeros(6), []
    for _ in setup.observations:
        across, ahead = direction(step, 2, random)
        walked = walked + np.array([across, 0.0, ahead, 0.0, signed(turn, random), 0.0])
        found.append(tuple(round(float(value), 4) for value in walked))
    return {'camera_scatter': tuple(found)}


def _coiled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body rolled up with its tip inmost."""
    free = setup.shape.length - setup.shape.clamp
    curvature = direction(2.0 * _MOVES[size] / free**2, 2, random)
    return {'curvature_form': 'coiled', 'rest_curvature': curvature}


def _vee(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {'contact_form': 'vee', 'contact_height': number((2.0, 5.0, 10.0)[size], random)}


def _castors(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Turn a table with rig and camera about on a floor that slopes."""
    share = min(_MOVES[size] / tip_sag(setup), _MOST_TILTED)
    across = signed(float(np.rad2deg(np.arcsin(share))), random)
    turn = signed(40.0, random)
    # About the world's x it draws across the body: midway through the poses, or nearly so.
    first = np.deg2rad(-0.5 * turn * (len(setup.observations) - 1) + random.uniform(-20.0, 20.0))
    tilt = (across * np.cos(first), -across * np.sin(first))
    return {
        'tilt_form': 'castors',
        'gravity_tilt': tuple(round(float(value), 4) for value in tilt),
        'tilt_turn': turn,
    }


ELEVENTH_FORMS = (
    Form('strain_stiffening', 'recruited', _recruited),
    Form('stiffness_contrast', 'slanted', _slanted),
    Form('added_mass', 'loose', _loose),
    Form('depth_bias_by_region', 'glossy', _glossy),
    Form('camera_offset', 'jostled', _jostled),
    Form('rest_curvature', 'coiled', _coiled),
    Form('contact_plane', 'vee', _vee),
    Form('gravity_tilt', 'castors', _castors),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
ELEVENTH_PAIRS = (
    ('strain_stiffening/recruited', 'clamp_offset/dragged'),
    ('added_mass/loose', 'depth_affine/walk'),
    ('rest_curvature/coiled', 'camera_offset/jostled'),
    ('stiffness_contrast/slanted', 'compliant_clamp/play'),
)
