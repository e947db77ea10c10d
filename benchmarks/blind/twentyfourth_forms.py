# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-fourth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.draught import opposed_share
from benchmarks.blind.flexure import stand_compliance
from benchmarks.blind.form import apart, Form
from benchmarks.blind.moduli import wedge_value
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import (
    aside_give,
    borne_way,
    even_sag,
    levers,
    SHARES,
    softness,
    towards,
)

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_CONTRAST = 5.0  # By which log E of one pour is more than that of the other.
_FARTHEST_CLICK = 2  # Number of clicks by which jaws are turned too far at most.
_MOST_BLOWN = (0.2, 0.4, 0.8)  # Of the weight, by which a fan pushes.
_GIVES = 0.8  # Of a tip's way, what a stand has of it: a body that is turned bends on.


def _spattered(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Spatter a body with drips of hot glue, here and there on all its sides."""
    count = int(random.integers(5, 9))
    places, around = random.uniform(0.25, 0.97, count), random.uniform(0.0, 360.0, count)
    parts = random.uniform(0.3, 1.0, count)
    parts /= parts.sum()
    lever = 0.375 * float(parts @ np.interp(places, SHARES, levers(setup)))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (lever * GRAVITY)
    drips = np.round(np.stack([places, around, parts], axis=1), 4)
    return {
        'mass_form': 'spattered',
        'added_mass': number(grams, random),
        'mass_drips': tuple(tuple(float(value) for value in drip) for drip in drips),
    }


def _wedged(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pour the soft part of a body first, into a mould that lies aslant on its side."""
    begin, until = (round(float(random.uniform(*ends)), 4) for ends in ((0.02, 0.12), (0.85, 1.0)))
    contrasts, across = np.linspace(0.0, _MOST_CONTRAST, 101), np.linspace(-0.95, 0.95, 20)
    pours = wedge_value(SHARES[:, None], across, begin, until)
    bears = np.exp(contrasts[:, None, None] * pours).mean(axis=2)
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    changes = even_sag(setup) * (1.0 / bears - 1.0) @ parts
    return {
        'contrast_mode': 'wedged',
        'contrast': number(float(np.interp(_MOVES[size], changes, contrasts)), random),
        'contrast_at': begin,
        'contrast_until': until,
        'contrast_side': float(random.choice([-1.0, 1.0])),
    }


def _stand(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Clamp a body on the arm of a chemist's stand, whose rod bends as well."""
    length = round(float(random.uniform(0.06, 0.12)), 4)
    most = borne_way(setup, stand_compliance(1.0, length))
    return {
        'clamp_form': 'stand',
        'clamp_compliance': number(_GIVES * _MOVES[size] / most, random),
        'clamp_length': length,
    }


def _clicking(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Turn jaws that swivel by clicks about an upright pin, and miscount them in some poses."""
    clicks, is_apart = np.ones(1), len(setup.observations) < 2
    while not is_apart:
        clicks = random.integers(-_FARTHEST_CLICK, _FARTHEST_CLICK + 1, len(setup.observations))
        is_apart = bool(np.abs(clicks).max() == _FARTHEST_CLICK and len(set(clicks)) > 2)
    click = number(float(np.rad2deg(_MOVES[size] / setup.shape.length)), random)
    # The pin is where the held section begins, and turns its middle beside that.
    angles, behind = np.deg2rad(click * clicks / _FARTHEST_CLICK), 500.0 * setup.shape.clamp
    found = [
        (behind * (np.cos(angle) - 1.0), behind * np.sin(angle), 0.0, 0.0, 0.0, np.rad2deg(angle))
        for angle in angles
    ]
    return {
        'clamp_scatter': tuple(
            tuple(round(float(value), 4) for value in motion) for motion in found
        )
    }


def _rack(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a drying rack on the bench below the body, between whose bars it hangs."""
    return {
        'contact_form': 'rack',
        'contact_height': number((2.0, 4.3, 10.5)[size], random),
        'contact_share': round(float(random.uniform(0.8, 0.95)), 4),
        'contact_wave': round(float(random.uniform(0.022, 0.03)), 4),
    }


def _peeling(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave the film on a new sensor's window, which peels off farther from pose to pose."""
    edge, places = random.uniform(-70.0, -30.0), []
    for _ in setup.observations:
        places.append(round(float(edge), 3))
        edge += random.uniform(12.0, 35.0)
    return {
        'depth_form': 'peeling',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        # From either side of the image, or from a corner.
        'depth_slant': round(float(random.choice([0.0, 180.0]) + random.uniform(-50.0, 50.0)), 3),
        'depth_width': round(float(random.uniform(6.0, 18.0)), 3),
        'depth_places': tuple(places),
    }


def _dipped(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Dip a body into paint some times, each time to another depth."""
    places = np.sort(random.uniform(0.2, 0.85, int(random.choice([4, 5]))))
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_dips': tuple(round(float(place), 4) for place in places),
    }


def _orbiting(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Swing a camera about the column of the rig, behind the body, and back by a dial."""
    behind = random.uniform(0.1, 0.2)
    places = apart(len(setup.observations), lambda count: random.uniform(-1.0, 1.0, count))
    half = 0.5 * (setup.shape.length - setup.shape.clamp)
    turn = number(float(np.rad2deg(_MOVES[size] / np.hypot(behind, half))), random)
    upright = setup.depth_from_world[:3, 1]
    foot = setup.depth_from_world[:3, 3] + np.array([0.0, 0.0, behind])
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, *(round(float(value), 4) for value in place * turn * upright))
            for place in places
        ),
        'camera_foot': tuple(round(float(value), 4) for value in foot),
    }


def _opposed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave two fans on that blow against each other, the outer one the more of a body."""
    border, back = (round(float(random.uniform(*ends)), 4) for ends in ((0.45, 0.6), (0.6, 1.0)))
    way = np.array([random.uniform(-0.4, 0.4), 0.0, 1.0])
    way /= np.linalg.norm(way)
    most = aside_give(setup, way)
    felt = float((levers(setup) * opposed_share(SHARES, border, back)).mean())
    share = min(_MOVES[size] / (even_sag(setup) * most * felt), _MOST_BLOWN[size])
    degrees = signed(float(np.rad2deg(np.arcsin(share))), random)
    return {
        'tilt_form': 'opposed',
        'gravity_tilt': towards(degrees, way),
        'tilt_at': border,
        'tilt_back': back,
    }


def _held_by_tip(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body level by its tip, with its holder at the free end."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'held by its tip',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_heavy': round(float(random.uniform(0.3, 0.7)), 4),
    }


TWENTYFOURTH_FORMS = (
    Form('added_mass', 'spattered', _spattered),
    Form('stiffness_contrast', 'wedged', _wedged),
    Form('compliant_clamp', 'stand', _stand),
    Form('clamp_offset', 'clicking', _clicking),
    Form('contact_plane', 'rack', _rack),
    Form('depth_affine', 'peeling', _peeling),
    Form('depth_bias_by_region', 'dipped', _dipped),
    Form('camera_offset', 'orbiting', _orbiting),
    Form('gravity_tilt', 'opposed', _opposed),
    Form('rest_curvature', 'held by its tip', _held_by_tip),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYFOURTH_PAIRS = (
    ('added_mass/spattered', 'depth_bias_by_region/dipped'),
    ('stiffness_contrast/wedged', 'clamp_offset/clicking'),
    ('compliant_clamp/stand', 'camera_offset/orbiting'),
    ('depth_affine/peeling', 'strain_stiffening/coils'),
)
