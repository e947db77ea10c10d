# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the eighteenth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.moduli import settled_share
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import even_sag, levers, SHARES, softness
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_BLOWN = 0.8  # Of the weight, by which a fan presses where it looks at a body.
_SWING = np.deg2rad(45.0)  # To either side of where a fan swings.
_STREAM = np.deg2rad(40.0)  # At which its push has fallen to a third.
_SINKS = 0.003  # By how much a body sinks into a crate's foam [m].
_MOST_GAPED = 0.8  # Of the held section, by which it is not held.


def _tool(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a tool on the tip, a gripper or a cube of tags, whose middle is ahead of it."""
    at = round(float(random.uniform(0.93, 0.95)), 4)
    ahead = round(float(random.uniform(15.0, 25.0)), 3)
    free, lever = setup.shape.length - setup.shape.clamp, levers(setup)
    # By reciprocity, a moment on a place moves the tip by the slope of what a load does there.
    slope = float(np.interp(at, SHARES, np.gradient(lever, SHARES)))
    whole = float(np.interp(at, SHARES, lever)) + 1e-3 * ahead / free * slope
    grams = 1.1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * whole * GRAVITY)
    return {
        'mass_form': 'tool',
        'added_mass': number(grams, random),
        'added_mass_at': at,
        'mass_ahead': ahead,
    }


def _threaded(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast threads into a body near its surface, which hang loose until it is bent enough."""
    return {
        'stiffening_form': 'threaded',
        'stiffening': number((0.3, 0.8, 5.0)[size], random),
        'stiffening_from': round(float(random.uniform(0.02, 0.05)), 4),
    }


def _settled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let a filler sink to the clamp's end before the rubber sets, or leave the hardener there."""
    end = round(float(random.uniform(0.5, 0.8)), 4)
    contrasts = np.linspace(0.0, float(random.choice([-2.5, 3.5])), 101)
    # By the tip's share of an even load's moments, (1 - share)^3, a part is stiffer by exp(c).
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    sags = even_sag(setup) * np.exp(-contrasts[:, None] * settled_share(SHARES, end)) @ parts
    changes = np.abs(sags - sags[0])
    return {
        'contrast_mode': 'settled',
        'contrast': number(float(np.interp(_MOVES[size], changes, contrasts)), random),
        'contrast_at': end,
    }


def _gaping(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a body by jaws that are worn at their mouth, and grip it farther in alone."""
    clamp, length = setup.shape.clamp, setup.shape.length
    (low, high), free = sorted(setup.shape.section), length - clamp
    bends = setup.youngs_modulus * high * low**3 / 12.0
    gapes = np.linspace(0.0, _MOST_GAPED * clamp, 101)
    # What is free in the jaws bends by the moment and the weight of all beyond it.
    moment = held_moment(setup)
    force = moment / (0.5 * length)
    moment -= 0.5 * force * clamp
    turns = (moment * gapes + 0.5 * force * gapes**2) / bends
    shifts = (0.5 * moment * gapes**2 + force * gapes**3 / 3.0) / bends
    gape = float(np.interp(_MOVES[size], shifts + turns * free, gapes))
    return {'clamp_gape': min(number(1e3 * gape, random), round(1e3 * _MOST_GAPED * clamp, 5))}


def _crate(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave the foam of a crate for eggs below the body, one of whose crests is below the tip."""
    beside = direction(0.006, 2, random)
    free, width = setup.shape.length - setup.shape.clamp, setup.shape.section[0]
    # Of what of the outer part lies on a crest.
    stiffness = tip_stiffness(setup) * _MOVES[size] / (0.1 * free * width * _SINKS)
    return {
        'contact_form': 'crate',
        'contact_height': number(1e3 * (_MOVES[size] + _SINKS), random),
        'contact_ahead': beside[0],
        'contact_at': beside[1],
        'contact_wave': round(float(random.uniform(0.045, 0.06)), 4),
        'contact_trough': round(float(random.uniform(0.01, 0.014)), 4),
        'contact_stiffness': number(stiffness, random),
    }


def _bounced(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a sheet of paper on the bench, whose light comes to the body from below."""
    ahead, aside = random.uniform(-0.06, 0.06, size=2)
    point = (ahead, -random.uniform(0.15, 0.2), aside)
    return {
        'depth_form': 'bounced',
        'depth_bias': number((1.5, 3.0, 7.5)[size], random),
        'depth_point': tuple(round(float(value), 4) for value in point),
    }


def _lengthwise(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Glue a strip of tape along the middle of each side, to follow the body's bend by."""
    return {
        'region_bias': signed((2.0, 4.2, 10.0)[size], random),
        'region_from': round(float(random.uniform(0.1, 0.3)), 4),
        'region_strip': round(float(random.uniform(0.5, 0.65)), 4),
    }


def _put_back(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Take a camera off its magnetic foot after each pose, and put it back for the next."""
    shift, turn = ((0.5, 0.3), (1.0, 0.6), (2.5, 1.5))[size]
    return {
        'camera_scatter': tuple(
            direction(shift, 3, random) + direction(turn, 3, random) for _ in setup.observations
        ),
        # Below its lens, in its own frame.
        'camera_foot': (0.0, round(float(random.uniform(0.03, 0.05)), 4), 0.0),
    }


def _fan(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a fan on which swings to and fro, so that it looks elsewhere in each pose."""
    looks = random.uniform(-_SWING, _SWING, len(setup.observations))
    felt = np.exp(-((looks / _STREAM) ** 2))
    felt /= felt.max()
    aslant, section = random.uniform(-0.4, 0.4), np.array(setup.shape.section)
    way = np.array([aslant, 0.0, 1.0])
    # A body gives way across its sides by the inverse square of how thick it is that way.
    gives = (section.min() / section) ** 2
    moves = [
        part * np.linalg.norm(gives * (pose.world_from_object[:3, 1:3].T @ way))
        for part, pose in zip(felt, setup.observations, strict=True)
    ]
    share = min(_MOVES[size] / (even_sag(setup) * float(max(moves))), _MOST_BLOWN)
    across = signed(float(np.rad2deg(np.arcsin(share))), random)
    return {
        'tilt_form': 'fan',
        # About the world's x it blows across the body, about z along it.
        'gravity_tilt': (across, round(float(-across * aslant), 4)),
        'tilt_shares': tuple(round(float(part), 4) for part in felt),
    }


def _overhanging(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Store a body on a table, with its outer part over the edge."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'overhanging',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_at': round(float(random.uniform(0.2, 0.45)), 4),
    }


EIGHTEENTH_FORMS = (
    Form('added_mass', 'tool', _tool),
    # Of a body that is softer, as all that stiffen are.
    Form('strain_stiffening', 'threaded', _threaded),
    Form('stiffness_contrast', 'settled', _settled),
    Form('compliant_clamp', 'gaping', _gaping),
    Form('contact_plane', 'crate', _crate),
    Form('depth_affine', 'bounced', _bounced),
    Form('depth_bias_by_region', 'lengthwise', _lengthwise),
    Form('camera_offset', 'put back', _put_back),
    Form('gravity_tilt', 'fan', _fan),
    Form('rest_curvature', 'overhanging', _overhanging),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
EIGHTEENTH_PAIRS = (
    ('added_mass/tool', 'camera_offset/put back'),
    ('compliant_clamp/gaping', 'depth_bias_by_region/lengthwise'),
    ('contact_plane/crate', 'depth_affine/bounced'),
    ('rest_curvature/overhanging', 'clamp_offset/loosening'),
)
