# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-second set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it: rubber that stiffens does so by less.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.moduli import crease_share
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import even_sag, levers, SHARES, softness, towards
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_CREASED = 4.0  # By which log E fell amid a crease.
_PLAY = (0.1, 0.25)  # Of what the strips of a hose are drawn most by, how much they have.
_BESIDE = 0.2  # Of a tip's way, by how much a spindle's axis is shifted.
_MOST_TILTED = 0.4  # Of the weight, by which a table that rocks draws aside in the largest size.


def _wicking(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast a cord into a body, which soaks up water from a leak at its clamp."""
    farthest, first = random.uniform(0.8, 0.95), random.uniform(0.4, 1.2)
    times = first + np.arange(len(setup.observations))
    # By the root of the time (Washburn 1921, Phys. Rev. 17).
    places = [round(float(place), 4) for place in farthest * np.sqrt(times / times[-1])]
    # What is along the body moves no tip.
    across = [float(np.hypot(*pose.world_from_object[1, 1:3])) for pose in setup.observations]
    arms = np.array([levers(setup)[place > SHARES].sum() for place in places])
    lever = float((across * arms).max()) / (len(SHARES) * places[-1])
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * lever * GRAVITY)
    return {
        'mass_form': 'wicking',
        'added_mass': number(grams, random),
        'mass_places': tuple(places),
    }


def _creased(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Mail a body folded twice, so that its rubber is soft around two creases."""
    inner, outer = (
        round(float(random.uniform(*ends)), 4) for ends in ((0.12, 0.25), (0.42, 0.55))
    )
    width = round(float(random.uniform(0.06, 0.09)), 4)
    contrasts = np.linspace(0.0, -_MOST_CREASED, 81)
    softer = np.expm1(-contrasts[:, None] * crease_share(SHARES, (inner, outer), width))
    # By the tip's share of an even load's moments, (1 - share)^3, a part is softer by that.
    changes = even_sag(setup) * softer @ ((1.0 - SHARES) ** 3 * softness(setup) / 50.0)
    return {
        'contrast_mode': 'creased',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
        'contrast_creases': (inner, outer),
        'contrast_width': width,
    }


def _interlocked(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast a body around the metal hose of a lamp's neck, whose strips have play either way."""
    # By how much the square of a length grows at most near the surface of an even bar.
    free = setup.shape.length - setup.shape.clamp
    drawn = 4.0 * even_sag(setup) * min(setup.shape.section) / free**2
    return {
        'stiffening_form': 'interlocked',
        'stiffening': number((0.4, 1.5, 10.0)[size], random),
        'stiffening_from': round(float(random.uniform(*_PLAY)) * drawn, 5),
    }


def _waxed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stick a body into a lump of wax, which flows by the moment of each pose and stays."""
    downs = -np.array([pose.world_from_object[1, :3] for pose in setup.observations])
    turns = np.cumsum(np.cross([1.0, 0.0, 0.0], downs), axis=0)
    most = float(np.linalg.norm(turns, axis=1).max())
    turn = _MOVES[size] / (setup.shape.length - 0.5 * setup.shape.clamp)
    return {
        'clamp_form': 'waxed',
        'clamp_compliance': number(turn / (most * held_moment(setup)), random),
    }


def _runout(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Roll a body by a spindle whose axis is aslant and beside where it should be."""
    slant, aside = (random.uniform(0.0, 2.0 * np.pi) for _ in range(2))
    turn = _MOVES[size] / (setup.shape.length - 0.5 * setup.shape.clamp)
    degrees = number(float(np.rad2deg(turn)), random)
    shift = 1e3 * _BESIDE * _MOVES[size] * np.array([0.0, np.cos(aside), np.sin(aside)])
    tilt = degrees * np.array([0.0, np.cos(slant), np.sin(slant)])
    found = []
    for pose in setup.observations:
        # By how much the object's z is rolled from upright, about its x.
        roll = float(np.arctan2(pose.world_from_object[1, 1], pose.world_from_object[1, 2]))
        back = rotation(np.array([-roll, 0.0, 0.0]))
        motion = (*(back @ shift), *(back @ tilt))
        found.append(tuple(round(float(value), 4) for value in motion))
    return {'clamp_scatter': tuple(found)}


def _pipe(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a piece of drain pipe on the bench below the outer part, which lies on its flank."""
    return {
        'contact_form': 'pipe',
        'contact_height': number((2.0, 4.3, 10.5)[size], random),
        'contact_at': signed(0.03, random),
        'contact_round': round(float(random.uniform(0.13, 0.18)), 4),
    }


def _warped(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Screw a sensor to a mount that is not flat, which warps its board to a saddle."""
    return {
        'depth_form': 'warped',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_slant': round(float(random.uniform(-90.0, 90.0)), 3),
        'depth_width': round(float(random.uniform(85.0, 110.0)), 3),
    }


def _luminous(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Paint the outer part with what glows after light, and fades from pose to pose."""
    rate = random.uniform(0.3, 0.9)
    shares = 1.0 / (1.0 + rate * np.arange(len(setup.observations)))
    return {
        'region_bias': signed((2.0, 4.2, 10.0)[size], random),
        'region_from': round(float(random.uniform(0.3, 0.65)), 4),
        'region_shares': tuple(round(float(share), 4) for share in shares),
    }


def _rocking(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stand all on a table with a short leg, which rocks to where the rig is heavy."""
    around = random.uniform(0.0, 2.0 * np.pi)
    way = np.array([np.cos(around), 0.0, np.sin(around)])
    turns = [pose.world_from_object[:3, :3] for pose in setup.observations]
    is_rocking = False
    while not is_rocking:
        heavy = random.standard_normal(3) * np.array([0.5, 1.0, 1.0])
        sides = [1.0 if way @ turn @ heavy > 0.0 else -1.0 for turn in turns]
        is_rocking = len(set(sides)) == min(len(sides), 2)
    section = np.array(setup.shape.section)
    # A body gives way across its sides by the inverse square of how thick it is that way.
    gives = (section.min() / section) ** 2
    most = max(float(np.linalg.norm(gives * (turn[:, 1:].T @ way))) for turn in turns)
    share = _MOVES[size] * min(1.0 / (even_sag(setup) * most), _MOST_TILTED / _MOVES[2])
    degrees = number(float(np.rad2deg(share)), random)
    return {
        'tilt_form': 'rocking',
        'gravity_tilt': towards(degrees, way),
        'tilt_shares': tuple(sides),
    }


def _propped(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body in its holder, where a block below the tip bears a part of its weight."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'propped',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_prop': round(float(random.uniform(0.45, 0.6)), 4),
    }


TWENTYSECOND_FORMS = (
    Form('added_mass', 'wicking', _wicking),
    Form('stiffness_contrast', 'creased', _creased),
    Form('strain_stiffening', 'interlocked', _interlocked),
    Form('compliant_clamp', 'waxed', _waxed),
    Form('clamp_offset', 'runout', _runout),
    Form('contact_plane', 'pipe', _pipe),
    Form('depth_affine', 'warped', _warped),
    Form('depth_bias_by_region', 'luminous', _luminous),
    Form('gravity_tilt', 'rocking', _rocking),
    Form('rest_curvature', 'propped', _propped),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYSECOND_PAIRS = (
    ('added_mass/wicking', 'depth_affine/warped'),
    ('stiffness_contrast/creased', 'depth_bias_by_region/luminous'),
    ('contact_plane/pipe', 'clamp_offset/runout'),
    ('compliant_clamp/waxed', 'camera_offset/sagging'),
)
