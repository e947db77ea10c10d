# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-sixth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.draught import spreading_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.filling import filled_shares
from benchmarks.blind.flexure import bobbin_compliance
from benchmarks.blind.form import Form
from benchmarks.blind.guard import farthest_way
from benchmarks.blind.moduli import gate_share
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import applied, rotation
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.shapes import FloatArray
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

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_SOFTENED = 5.0  # By which log E is less where it is farthest from a mould's gate.
_SOFTER = 0.3  # Of its modulus a body has where it is to be strained, as the generator has it.
_UPPERMOST = 0.25  # Of the height, which a tape along the upper side has.
_MOST_STIFF = 30.0  # E of a tape that is straight, over that of rubber.
_STIFFER = 1.2  # Than by an even bar's sag: a tape is drawn late, and a soft body sags less.
_MOST_HELD = 0.5  # Of a body's sag, by which a tape lessens that.
_RUFFLED = (0.1, 0.25)  # Of what a stiffer body is drawn most by, how far ruffles let it.
_GIVES = 0.8  # Of a tip's way, what bobbins have of it: a body that is turned bends on.
_MOST_BLOWN = (0.25, 0.5, 0.95)  # Of the weight, by which a hair dryer pushes where it is stated.


def _filling(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a cup hanging below a body, into which a tap drips from pose to pose."""
    at = round(float(random.uniform(0.6, 0.92)), 4)
    shares = filled_shares(len(setup.observations), random.uniform(0.2, 0.45))
    # What is along the body moves no tip.
    most = max(
        share * float(np.hypot(*pose.world_from_object[1, 1:3]))
        for share, pose in zip(shares, setup.observations, strict=True)
    )
    lever = 0.375 * float(np.interp(at, SHARES, levers(setup)))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (lever * most * GRAVITY)
    return {
        'mass_form': 'filling',
        'added_mass': number(grams, random),
        'added_mass_at': at,
        'mass_shares': shares,
    }


def _gated(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Fill a mould through one gate, slowly: what flowed far from there is softer."""
    at = round(float(random.uniform(0.5, 0.75)), 4)
    contrasts = np.linspace(0.0, -_MOST_SOFTENED, 101)
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    softer = np.exp(-contrasts[:, None] * gate_share(SHARES, at))
    changes = even_sag(setup) * (softer - 1.0) @ parts
    return {
        'contrast_mode': 'gated',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
        'contrast_at': at,
    }


def _ruffled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stick a tape on the upper side, in ruffles that are drawn straight where it bends down."""
    held = min(_STIFFER * _MOVES[size] * _SOFTER / even_sag(setup), _MOST_HELD)
    return {
        'stiffening_form': 'ruffled',
        'stiffening': number(side_stiffness(held, _UPPERMOST, _MOST_STIFF), random),
        'stiffening_from': round(float(random.uniform(*_RUFFLED)) * most_drawn(setup), 5),
    }


def _bobbins(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Put a clamp's plate on four rubber bobbins, which keep the bench's shaking from it."""
    length = round(float(random.uniform(0.03, 0.06)), 4)
    most = borne_way(setup, bobbin_compliance(1.0, length))
    return {
        'clamp_form': 'bobbins',
        'clamp_compliance': number(_GIVES * _MOVES[size] / most, random),
        'clamp_length': length,
    }


def _homed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Home the upright table that turns a rig at a wrong angle, which stays in all poses."""
    behind = round(float(random.uniform(0.0, 0.02)), 4)
    reach = max(float(np.hypot(*pose.world_from_object[[0, 2], 0])) for pose in setup.observations)
    angle = signed(_MOVES[size] / ((setup.shape.length + behind) * reach), random)
    arm, found = 1e3 * (0.5 * setup.shape.clamp + behind) * np.array([1.0, 0.0, 0.0]), []
    for pose in setup.observations:
        turn = angle * pose.world_from_object[1, :3]
        shift = rotation(turn) @ arm - arm
        found.append(tuple(round(float(value), 4) for value in (*shift, *np.rad2deg(turn))))
    return {'clamp_scatter': tuple(found)}


def _splash_guard(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Bend a sheet of acrylic before a sensor, to guard that from splashes."""
    across, down = random.uniform(-30.0, 30.0, 2)
    slant = round(float(random.uniform(-25.0, 25.0)), 3)
    return {
        'depth_form': 'splash guard',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_spot': (round(float(across), 3), round(float(down), 3)),
        'depth_slant': slant,
        # How far off a body's end is at most.
        'depth_width': round(farthest_way(setup, (across, down), slant), 3),
    }


def _stickers(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Put a row of round stickers on each side, by which people know bodies from each other."""
    radius = float(random.uniform(0.007, 0.0085))
    apart = radius * float(random.uniform(2.1, 2.5))
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(random.uniform(0.15, 0.3)), 4),
        'region_stickers': (round(apart, 5), round(radius, 5)),
    }


def _rolled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let a camera slip in a loose collar, and roll about the way it looks from pose to pose."""
    half = 0.5 * (setup.shape.length - setup.shape.clamp)
    most = signed(float(np.rad2deg(_MOVES[size] / half)), random)
    slips = np.cumsum(random.uniform(0.2, 1.0, len(setup.observations)))
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, 0.0, 0.0, round(float(most * share), 4)) for share in slips / slips[-1]
        ),
        'camera_foot': (0.0, 0.0, 0.0),
    }


def _hair_dryer(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a hair dryer on that was put down beside the rig, to dry a body."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    ahead = shape.clamp + np.append(SHARES, random.uniform(0.75, 0.95)) * (
        shape.length - shape.clamp
    )
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    away = round(float(random.uniform(0.3, 0.45)), 4)
    way = np.array([random.uniform(-0.3, 0.3), 0.0, float(random.choice([-1.0, 1.0]))])
    way /= np.linalg.norm(way)
    point = tuple(round(float(value), 5) for value in places[-1])
    felt = _felt(places[:-1], way, Faults(tilt_point=point, tilt_away=away), setup)
    share = min(
        _MOVES[size] / (even_sag(setup) * aside_give(setup, way) * felt), _MOST_BLOWN[size]
    )
    return {
        'tilt_form': 'hair dryer',
        'gravity_tilt': towards(number(float(np.rad2deg(np.arcsin(share))), random), way),
        'tilt_point': point,
        'tilt_away': away,
    }


def _felt(places: FloatArray, way: FloatArray, jet: Faults, setup: Setup) -> float:
    """Return how far a jet moves a tip, over what as much does that is alike all along a body."""
    return float((spreading_share(places, way, jet) * levers(setup)).mean())


def _burdened(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Forget a bag on a body over the holidays, which hung at one place of it."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'burdened',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_at': round(float(random.uniform(0.4, 0.7)), 4),
    }


TWENTYSIXTH_FORMS = (
    Form('added_mass', 'filling', _filling),
    Form('stiffness_contrast', 'gated', _gated),
    # Of a body that is softer, as all that stiffen are.
    Form('strain_stiffening', 'ruffled', _ruffled),
    Form('compliant_clamp', 'bobbins', _bobbins),
    Form('clamp_offset', 'homed', _homed),
    Form('depth_affine', 'splash guard', _splash_guard),
    Form('depth_bias_by_region', 'stickers', _stickers),
    Form('camera_offset', 'rolled', _rolled),
    Form('gravity_tilt', 'hair dryer', _hair_dryer),
    Form('rest_curvature', 'burdened', _burdened),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYSIXTH_PAIRS = (
    ('added_mass/filling', 'camera_offset/rolled'),
    ('stiffness_contrast/gated', 'depth_affine/splash guard'),
    ('compliant_clamp/bobbins', 'depth_bias_by_region/stickers'),
    ('clamp_offset/homed', 'contact_plane/cushion'),
)
