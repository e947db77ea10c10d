# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-ninth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.draught import screened_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import coil_compliance
from benchmarks.blind.form import Form
from benchmarks.blind.masses import turn_density
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.pitching import joint_errors, pitched_on, stated_pitches
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import (
    aside_give,
    borne_way,
    even_sag,
    levers,
    most_drawn,
    SHARES,
    side_stiffness,
    softness,
    towards,
)
from benchmarks.blind.surging import surged_value

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
# By which these are drawn larger, as loaded bodies turn from their loads.
_SURGED_MORE, _BLOWN_MORE = 1.4, 1.25
_MOST_SURGED = 5.0  # By which log E is less at the clamp.
_SOFTER = 0.3  # Of its modulus a body has where it is to be strained, as the generator has it.
_SIDE = 0.25  # Of the height, which cords along one side have.
_MOST_STIFF = 30.0  # E of cords at first, over that of rubber.
_MOST_HELD = 0.5  # Of a body's sag, by which cords lessen that.
_STRAIGHT = (2.0, 3.0)  # Where cords are straight, over what a stiffer body is drawn most by.
_GIVES = 0.8  # Of a tip's way, what a spring has of it: a body that is turned bends on.
_MOST_BENT = 75.0  # Of the shafts of a universal joint [deg].
_SINKS = 0.003  # By how much a body sinks into gel where it lies on that [m].
_MOST_BLOWN = (0.3, 0.6, 0.95)  # Of the weight, by which air blows far beside a screen.


def _solder(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Wind solder around a body to load it, closer and closer towards the tip."""
    closer = round(float(random.uniform(0.2, 0.35)), 4)
    turns = turn_density(SHARES, closer)
    # What is along the body moves no tip.
    most = max(float(np.hypot(*pose.world_from_object[1, 1:3])) for pose in setup.observations)
    lever = 0.375 * float(levers(setup) @ turns / turns.sum()) * most
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (lever * GRAVITY)
    return {
        'mass_form': 'solder',
        'added_mass': number(grams, random),
        'mass_closer': closer,
    }


def _surged(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Fill a mould from its clamp's end by a mixing pump that surged when it was switched on."""
    wave, width = (round(float(random.uniform(*ends)), 4) for ends in ((0.6, 0.9), (0.3, 0.5)))
    contrasts = np.linspace(0.0, -_MOST_SURGED, 101)
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    softer = np.exp(-contrasts[:, None] * surged_value(SHARES, wave, width))
    changes = even_sag(setup) * (softer - 1.0) @ parts / _SURGED_MORE
    return {
        'contrast_mode': 'surged',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
        'contrast_wave': wave,
        'contrast_width': width,
    }


def _corded(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Glue curly cords along the upper and the lower side, which go straight and no further."""
    held = min(_MOVES[size] * _SOFTER / even_sag(setup), _MOST_HELD)
    return {
        'stiffening_form': 'corded',
        'stiffening': number(side_stiffness(held, _SIDE, _MOST_STIFF), random),
        'stiffening_from': round(float(random.uniform(*_STRAIGHT)) * most_drawn(setup), 5),
    }


def _coil_spring(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stand a clamp on a coil spring, which keeps the bench's shaking from it."""
    height = round(float(random.uniform(0.03, 0.06)), 4)
    most = borne_way(setup, coil_compliance(1.0, height))
    return {
        'clamp_form': 'coil spring',
        'clamp_compliance': number(_GIVES * _MOVES[size] / most, random),
        'clamp_length': height,
    }


def _universal_joint(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pitch jaws through a universal joint, whose shafts are bent off each other."""
    phase = float(random.choice([0.0, 0.5 * np.pi])) + random.uniform(-0.2, 0.2)
    bends, pitches = np.deg2rad(np.linspace(0.0, _MOST_BENT, 301)), stated_pitches(setup)
    most = [np.abs(joint_errors(pitches, phase, bent)).max() for bent in bends]
    bent = float(np.interp(number(_MOVES[size] / setup.shape.length, random), most, bends))
    return {'clamp_scatter': pitched_on(setup, joint_errors(pitches, phase, bent))}


def _gel_pad(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a pad of gel below the tip, as people rest their wrists on."""
    bend = round(float(random.uniform(0.002, 0.003)), 5)
    free, width = setup.shape.length - setup.shape.clamp, setup.shape.section[0]
    # Of the outer fifth, which lies on it.
    pressure = tip_stiffness(setup) * _MOVES[size] / (0.2 * free * width)
    dent = _SINKS / bend
    return {
        'contact_form': 'gel pad',
        'contact_height': number(1e3 * (_MOVES[size] + _SINKS), random),
        'contact_pressure': number(pressure / (dent + dent**3), random),
        'contact_bend': bend,
    }


def _tongues(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a sleeve over the tip that is cut to a tongue on each side."""
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(random.uniform(0.1, 0.25)), 4),
        'region_tongue': round(float(random.uniform(0.8, 0.95)), 4),
    }


def _twisting(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hang a camera from a cord, on which it still turns to and fro, less and less."""
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    most = signed(float(np.rad2deg(_MOVES[size] / distance)), random)
    phase, rate, decay = (
        random.uniform(*ends) for ends in ((0.0, 2.0 * np.pi), (1.5, 2.5), (0.1, 0.3))
    )
    times = np.arange(len(setup.observations))
    swings = np.exp(-decay * times) * np.cos(rate * times + phase)
    upright = setup.depth_from_world[:3, 1]
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, *(round(float(value), 4) for value in most * swing * upright))
            for swing in swings / np.abs(swings).max()
        ),
        'camera_foot': (0.0, 0.0, 0.0),
    }


def _screened(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Put up a screen against a draught, past whose upright edge the tip stands out."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    ahead = shape.clamp + np.append(SHARES, random.uniform(0.35, 0.65)) * (
        shape.length - shape.clamp
    )
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    way = np.array([random.uniform(-0.3, 0.3), 0.0, float(random.choice([-1.0, 1.0]))])
    way /= np.linalg.norm(way)
    point = tuple(round(float(value), 5) for value in places[-1])
    # On the side of the tip it blows.
    outer = np.sign((places[-2] - places[-1]) @ np.cross(way, [0.0, 1.0, 0.0]))
    width = round(float(outer * random.uniform(0.015, 0.03)), 4)
    edge = Faults(tilt_point=point, tilt_width=width)
    felt = float((screened_share(places[:-1], way, edge) * levers(setup)).mean())
    whole = even_sag(setup) * aside_give(setup, way) * felt
    share = min(_BLOWN_MORE * _MOVES[size] / whole, _MOST_BLOWN[size])
    return {
        'tilt_form': 'screened',
        'gravity_tilt': towards(number(float(np.rad2deg(np.arcsin(share))), random), way),
        'tilt_point': point,
        'tilt_width': width,
    }


def _four_point(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Store a body on its two ends, below a board that stands on it with two feet."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'four-point',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_at': round(float(random.uniform(0.25, 0.4)), 4),
        'curvature_again': round(float(random.uniform(0.65, 0.85)), 4),
    }


TWENTYNINTH_FORMS = (
    Form('added_mass', 'solder', _solder),
    Form('stiffness_contrast', 'surged', _surged),
    # Of a body that is softer, as all that stiffen are.
    Form('strain_stiffening', 'corded', _corded),
    Form('compliant_clamp', 'coil spring', _coil_spring),
    Form('clamp_offset', 'universal joint', _universal_joint),
    Form('contact_plane', 'gel pad', _gel_pad),
    Form('depth_bias_by_region', 'tongues', _tongues),
    Form('camera_offset', 'twisting', _twisting),
    Form('gravity_tilt', 'screened', _screened),
    Form('rest_curvature', 'four-point', _four_point),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYNINTH_PAIRS = (
    ('added_mass/solder', 'camera_offset/twisting'),
    ('compliant_clamp/coil spring', 'depth_bias_by_region/tongues'),
    ('clamp_offset/universal joint', 'strain_stiffening/corded'),
    ('rest_curvature/four-point', 'depth_affine/toed'),
)
