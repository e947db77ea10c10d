# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-eighth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.baking import baked_value
from benchmarks.blind.draught import lee_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import gooseneck_compliance
from benchmarks.blind.form import Form
from benchmarks.blind.guard import farthest_way
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.pitching import eccentric_errors, pitched_on, stated_pitches
from benchmarks.blind.rotations import applied
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
from benchmarks.blind.slinky import coil_places

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_SOFTENED = 5.0  # By which log E is less at a mould's hottest end.
_GIVES = 0.8  # Of a tip's way, what a gooseneck has of it: a body that is turned bends on.
_COILED_MORE, _SOFTENED_MORE, _BLOWN_MORE = (
    1.15,
    1.25,
    1.25,
)  # As loaded bodies turn from their loads.
_MOST_BLOWN = (0.3, 0.6, 0.95)  # Of the weight, by which air blows far beside a post.


def _slinky(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a loose spring around a body, which its own weight draws out."""
    ranges = ((0.2, 0.35), (0.3, 0.45), (0.1, 0.14))
    at, coiled, travel = (round(float(random.uniform(*ends)), 4) for ends in ranges)
    spring = Faults(added_mass_at=at, mass_coiled=coiled, mass_travel=travel)
    # What is along the body moves no tip.
    most = max(
        float(np.hypot(*pose.world_from_object[1, 1:3]))
        * float(np.interp(coil_places(pose, spring), SHARES, levers(setup)).mean())
        for pose in setup.observations
    )
    grams = _COILED_MORE * 1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * most * GRAVITY)
    return {
        'mass_form': 'slinky',
        'added_mass': number(grams, random),
        'added_mass_at': at,
        'mass_coiled': coiled,
        'mass_travel': travel,
    }


def _baked(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Bake a mould for too long between two hot blocks, so that rubber reverted near both."""
    at, width = (round(float(random.uniform(*ends)), 4) for ends in ((0.48, 0.65), (0.16, 0.24)))
    contrasts = np.linspace(0.0, -_MOST_SOFTENED, 101)
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    softer = np.exp(-contrasts[:, None] * baked_value(SHARES, at, width))
    changes = even_sag(setup) * (softer - 1.0) @ parts / _SOFTENED_MORE
    return {
        'contrast_mode': 'baked',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
        'contrast_at': at,
        'contrast_width': width,
    }


def _gooseneck(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a clamp by a gooseneck, a rod that comes over in a bend."""
    radius = round(float(random.uniform(0.03, 0.06)), 4)
    most = borne_way(setup, gooseneck_compliance(1.0, radius))
    return {
        'clamp_form': 'gooseneck',
        'clamp_compliance': number(_GIVES * _MOVES[size] / most, random),
        'clamp_length': radius,
    }


def _eccentric(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pitch jaws by a dial whose disc was not mounted about its middle."""
    phase = signed(0.9, random)
    errors = eccentric_errors(stated_pitches(setup), phase)
    most = signed(_MOVES[size] / setup.shape.length, random)
    return {
        'clamp_scatter': pitched_on(setup, most / float(np.abs(errors).max()) * errors),
    }


def _tent(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a folded card on the bench below a body, which stands there like a tent."""
    ahead, aside = direction(0.006, 2, random)
    return {
        'contact_form': 'tent',
        'contact_height': number((2.0, 4.3, 10.5)[size], random),
        'contact_ahead': ahead,
        'contact_at': aside,
        'contact_steep': round(float(random.uniform(0.25, 0.45)), 4),
        'contact_round': round(float(random.uniform(0.01, 0.02)), 4),
        'contact_slant': signed(30.0, random),
    }


def _shifted_bar(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Mount a stereo sensor's bar on two posts, one of which is higher than the other."""
    across, down = random.uniform(-30.0, 30.0, 2)
    slant = round(float(random.uniform(-25.0, 25.0)), 3)
    return {
        'depth_form': 'shifted bar',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_spot': (round(float(across), 3), round(float(down), 3)),
        'depth_slant': slant,
        # How far off a body's end is at most.
        'depth_width': round(farthest_way(setup, (float(across), float(down)), slant), 3),
    }


def _polished(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let hands polish a body around the place where people take hold of it."""
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_bell': tuple(
            round(float(random.uniform(*ends)), 4) for ends in ((0.5, 0.8), (0.16, 0.26))
        ),
    }


def _wedge(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Turn a filter before the lens from pose to pose whose faces are not parallel."""
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    bent = number(float(np.rad2deg(_MOVES[size] / distance)), random)
    ways = random.uniform(0.0, 2.0 * np.pi) + np.cumsum(
        random.uniform(0.7, 2.2, len(setup.observations))
    )
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, round(float(turn[0]), 4), round(float(turn[1]), 4), 0.0)
            for turn in bent * np.column_stack([np.cos(ways), np.sin(ways)])
        ),
        'camera_foot': (0.0, 0.0, 0.0),
    }


def _lee(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a window open whose draught comes from the side, past an upright post."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    ahead = shape.clamp + np.append(SHARES, random.uniform(0.35, 0.75)) * (
        shape.length - shape.clamp
    )
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    way = np.array([random.uniform(-0.3, 0.3), 0.0, float(random.choice([-1.0, 1.0]))])
    way /= np.linalg.norm(way)
    point = tuple(round(float(value), 5) for value in places[-1])
    width = round(float(random.uniform(0.02, 0.035)), 4)
    post = Faults(tilt_point=point, tilt_width=width)
    felt = float((lee_share(places[:-1], way, post) * levers(setup)).mean())
    whole = even_sag(setup) * aside_give(setup, way) * felt
    share = min(_BLOWN_MORE * _MOVES[size] / whole, _MOST_BLOWN[size])
    return {
        'tilt_form': 'lee',
        'gravity_tilt': towards(number(float(np.rad2deg(np.arcsin(share))), random), way),
        'tilt_point': point,
        'tilt_width': width,
    }


def _mattress(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Store a body on a mattress, into which its heavy holder sank."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'mattress',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_bed': round(float(random.uniform(0.15, 0.25)), 4),
    }


TWENTYEIGHTH_FORMS = (
    Form('added_mass', 'slinky', _slinky),
    Form('stiffness_contrast', 'baked', _baked),
    Form('compliant_clamp', 'gooseneck', _gooseneck),
    Form('clamp_offset', 'eccentric', _eccentric),
    Form('contact_plane', 'tent', _tent),
    Form('depth_affine', 'shifted bar', _shifted_bar),
    Form('depth_bias_by_region', 'polished', _polished),
    Form('camera_offset', 'wedge', _wedge),
    Form('gravity_tilt', 'lee', _lee),
    Form('rest_curvature', 'mattress', _mattress),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYEIGHTH_PAIRS = (
    ('added_mass/slinky', 'camera_offset/wedge'),
    ('compliant_clamp/gooseneck', 'depth_affine/shifted bar'),
    ('stiffness_contrast/baked', 'depth_bias_by_region/polished'),
    ('rest_curvature/mattress', 'strain_stiffening/foam strip'),
)
