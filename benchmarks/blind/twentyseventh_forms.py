# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-seventh set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.dosing import dosed_value
from benchmarks.blind.draught import louvre_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.form import Form
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.pitching import pitched_on, stated_pitches
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import (
    aside_give,
    even_sag,
    levers,
    most_drawn,
    SHARES,
    side_stiffness,
    softness,
    towards,
)
from benchmarks.blind.slider import slid_to

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
# By which these are drawn larger, as loaded bodies turn from their loads.
_SLID, _DOSED_MORE, _BLOWN_MORE = 1.5, 1.25, 1.25
_MOST_CONTRAST = 5.0  # By which log E grows in one stroke of a pump.
_SOFTER = 0.3  # Of its modulus a body has where it is to be strained, as the generator has it.
_LOWEST = 0.25  # Of the height, which a strip of foam along the lower side has.
_MOST_STIFF = 30.0  # E of a strip of foam at first, over that of rubber.
_MOST_HELD = 0.5  # Of a body's sag, by which a strip lessens that.
_STEEP = (0.3, 0.8)  # Exponent of a strip where a stiffer body is drawn most.
_MOST_BLOWN = (0.3, 0.6, 0.95)  # Of the weight, by which a grille blows amid two slats.


def _sliding(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Put a weight on a body that slides along it on a spring."""
    at, travel = (round(float(random.uniform(*ends)), 4) for ends in ((0.5, 0.7), (0.2, 0.35)))
    slider = Faults(added_mass_at=at, mass_travel=travel)
    there = [slid_to(pose, slider) for pose in setup.observations]
    # What is along the body moves no tip.
    across = [np.hypot(*pose.world_from_object[1, 1:3]) for pose in setup.observations]
    most = float((np.array(across) * np.interp(there, SHARES, levers(setup))).max())
    grams = _SLID * 1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * most * GRAVITY)
    return {
        'mass_form': 'sliding',
        'added_mass': number(grams, random),
        'added_mass_at': at,
        'mass_travel': travel,
    }


def _dosed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Fill a mould by strokes of a pump, each of which brings more hardener towards its end."""
    at, wave = (round(float(random.uniform(*ends)), 4) for ends in ((-0.04, 0.06), (0.4, 0.6)))
    contrasts = np.linspace(0.0, _MOST_CONTRAST, 101)
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    softer = np.exp(-contrasts[:, None] * dosed_value(SHARES, at, wave))
    changes = even_sag(setup) * (softer - 1.0) @ parts
    return {
        'contrast_mode': 'dosed',
        'contrast': number(
            float(np.interp(_DOSED_MORE * _MOVES[size], changes, contrasts)), random
        ),
        'contrast_at': at,
        'contrast_wave': wave,
    }


def _foam_strip(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Glue a strip of foam along the lower side, which grows dense where it bends down."""
    held = min(_MOVES[size] * _SOFTER / even_sag(setup), _MOST_HELD)
    return {
        'stiffening_form': 'foam strip',
        'stiffening': number(side_stiffness(held, _LOWEST, _MOST_STIFF), random),
        'stiffening_steep': round(float(random.uniform(*_STEEP)) / most_drawn(setup) ** 2, 4),
    }


def _backlash(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pitch jaws by a worn worm: they lag behind the way in which it turned last."""
    before = float(random.choice([-np.pi, np.pi]))
    ways = np.sign(np.diff(stated_pitches(setup), prepend=before))
    lost = number(_MOVES[size] / setup.shape.length, random)
    return {'clamp_scatter': pitched_on(setup, [-lost * float(way) for way in ways])}


def _corrugated(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a corrugated sheet on the bench below the body, aslant."""
    ahead, aside = direction(0.006, 2, random)
    return {
        'contact_form': 'corrugated',
        'contact_height': number((2.0, 4.3, 10.5)[size], random),
        'contact_ahead': ahead,
        'contact_at': aside,
        'contact_wave': round(float(random.uniform(0.035, 0.05)), 4),
        'contact_trough': round(float(random.uniform(0.004, 0.006)), 4),
        'contact_slant': signed(35.0, random),
    }


def _two_taps(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Read out both halves of an imager by circuits whose zeros are off."""
    return {
        'depth_form': 'two taps',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_spot': (round(float(random.uniform(-25.0, 25.0)), 3), 0.0),
        'depth_back': round(float(random.uniform(0.3, 1.0)), 4),
    }


def _netted(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a sleeve of coarse net over the outer part."""
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(random.uniform(0.15, 0.3)), 4),
        'region_net': tuple(
            round(float(random.uniform(*ends)), 5) for ends in ((0.014, 0.018), (0.3, 0.4))
        ),
    }


def _mirror(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Film by a mirror before the lens whose hinge creeps: less and less from pose to pose."""
    away = round(float(random.uniform(0.08, 0.13)), 4)
    # What is seen turns about the mirror's hinge, and by twice as much as that.
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    turn = signed(float(np.rad2deg(_MOVES[size] / (distance - away))), random)
    slant, rate = np.deg2rad(random.uniform(-30.0, 30.0)), random.uniform(1.0, 4.0)
    crept = np.log1p(rate * (np.arange(len(setup.observations)) + 0.3))
    axis = np.array([np.cos(slant), np.sin(slant), 0.0])
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, *(round(float(value), 4) for value in share * turn * axis))
            for share in crept / crept[-1]
        ),
        'camera_foot': (0.0, 0.0, away),
    }


def _louvred(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave an air conditioner on, whose grille has upright slats."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    ahead = shape.clamp + np.append(SHARES, random.uniform(0.8, 0.95)) * (
        shape.length - shape.clamp
    )
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    way = np.array([random.uniform(-0.3, 0.3), 0.0, float(random.choice([-1.0, 1.0]))])
    way /= np.linalg.norm(way)
    point = tuple(round(float(value), 5) for value in places[-1])
    wave = round(float(random.uniform(0.06, 0.1)), 4)
    grille = Faults(tilt_point=point, tilt_wave=wave)
    felt = float((louvre_share(places[:-1], way, grille) * levers(setup)).mean())
    whole = even_sag(setup) * aside_give(setup, way) * felt
    share = min(_BLOWN_MORE * _MOVES[size] / whole, _MOST_BLOWN[size])
    return {
        'tilt_form': 'louvred',
        'gravity_tilt': towards(number(float(np.rad2deg(np.arcsin(share))), random), way),
        'tilt_point': point,
        'tilt_wave': wave,
    }


def _hammock(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hang a body up by both ends between two hooks, loosely, as a hammock is."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'hammock',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_at': round(float(random.uniform(0.35, 0.6)), 4),
        'curvature_sag': round(float(random.uniform(0.15, 0.3)), 4),
    }


TWENTYSEVENTH_FORMS = (
    Form('added_mass', 'sliding', _sliding),
    Form('stiffness_contrast', 'dosed', _dosed),
    # Of a body that is softer, as all that stiffen are.
    Form('strain_stiffening', 'foam strip', _foam_strip),
    Form('clamp_offset', 'backlash', _backlash),
    Form('contact_plane', 'corrugated', _corrugated),
    Form('depth_affine', 'two taps', _two_taps),
    Form('depth_bias_by_region', 'netted', _netted),
    Form('camera_offset', 'mirror', _mirror),
    Form('gravity_tilt', 'louvred', _louvred),
    Form('rest_curvature', 'hammock', _hammock),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYSEVENTH_PAIRS = (
    ('added_mass/sliding', 'depth_affine/two taps'),
    ('stiffness_contrast/dosed', 'camera_offset/mirror'),
    ('clamp_offset/backlash', 'depth_bias_by_region/netted'),
    ('rest_curvature/hammock', 'compliant_clamp/stand'),
)
