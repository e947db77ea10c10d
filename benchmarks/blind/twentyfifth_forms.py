# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-fifth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import number, signed
from benchmarks.blind.cradle import outer_part
from benchmarks.blind.draught import curtain_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import suction_compliance
from benchmarks.blind.form import Form
from benchmarks.blind.moduli import ribbon_share
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.pitching import pitched_on, stated_pitches
from benchmarks.blind.rotations import applied
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
_MOST_SOFTENED = 5.0  # By which log E of a ribbon's middle is less.
_SOFTER = 0.3  # Of its modulus a body has where it is to be strained, as the generator has it.
_LOWEST = 0.25  # Of the height, which blocks along the lower side have.
_MOST_STIFF = 30.0  # E of a row of blocks that touch, over that of rubber.
_STIFFER = 2.0  # Than by an even bar's sag: blocks touch late, and a soft body sags less.
_MOST_HELD = 0.58  # Of a body's sag, by which blocks lessen that.
_APART = (0.1, 0.25)  # Of what a stiffer body is pressed most by, how far blocks lie apart.
_GIVES = 0.8  # Of a tip's way, what a suction cup has of it: a body that is turned bends on.
_MOST_BLOWN = (0.25, 0.5, 0.95)  # Of the weight, by which a curtain of air pushes.


def _cradled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hang a weight below a body in two threads, to load it in two places."""
    free = setup.shape.length - setup.shape.clamp
    inner, outer = (round(float(random.uniform(*ends)), 4) for ends in ((0.35, 0.5), (0.82, 0.95)))
    drop = round(float(random.uniform(0.012, 0.025)), 4)
    at_inner, at_outer = np.interp((inner, outer), SHARES, levers(setup))
    most = 0.0
    for pose in setup.observations:
        down = -pose.world_from_object[1, :3]
        part = outer_part(down, drop, (outer - inner) * free)
        # What is along the body moves no tip.
        across = float(np.hypot(down[1], down[2]))
        most = max(most, across * float((1.0 - part) * at_inner + part * at_outer))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * most * GRAVITY)
    return {
        'mass_form': 'cradled',
        'added_mass': number(grams, random),
        'mass_stops': (inner, outer),
        'mass_drop': drop,
    }


def _ribbon(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pour a softer rubber into a mould with the other, as a ribbon that winds around both."""
    drawn: dict[str, Any] = {
        'contrast_wave': round(float(random.uniform(0.5, 0.9)), 4),
        'contrast_at': round(float(random.uniform(0.0, 0.5)), 4),
        'contrast_side': float(random.choice([-1.0, 1.0])),
    }
    contrasts = np.linspace(0.0, -_MOST_SOFTENED, 41)
    changes = np.maximum.accumulate(_ribbon_moves(setup, contrasts, Faults(**drawn)))
    return {
        'contrast_mode': 'ribbon',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
        **drawn,
    }


def _ribbon_moves(setup: Setup, contrasts: FloatArray, faults: Faults) -> FloatArray:
    """Return by how much farther a tip sags by its weight for a ribbon's contrasts [m], (K,)."""
    ticks = (np.arange(16) + 0.5) / 8.0 - 1.0
    wide, high = np.meshgrid(ticks, ticks)
    where = ribbon_share(SHARES[:, None, None], wide, high, faults)
    # Across its thin side a body gives way most.
    thin = high if setup.shape.section[1] <= setup.shape.section[0] else wide
    found = []
    for contrast in contrasts:
        stiff = np.exp(contrast * where)
        whole, first, second = ((stiff * thin**power).sum(axis=(1, 2)) for power in range(3))
        found.append((second - first**2 / whole) / (thin**2).sum())
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    return np.asarray(even_sag(setup) * (1.0 / np.array(found) - 1.0) @ parts)


def _vertebrae(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast hard blocks into a body along its lower side, which touch where it bends down."""
    held = min(_STIFFER * _MOVES[size] * _SOFTER / even_sag(setup), _MOST_HELD)
    return {
        'stiffening_form': 'vertebrae',
        'stiffening': number(side_stiffness(held, _LOWEST, _MOST_STIFF), random),
        'stiffening_from': round(float(random.uniform(*_APART)) * most_drawn(setup), 5),
    }


def _suction(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a clamp by the suction cup of a gripper, whose wall gives way."""
    width = round(float(random.uniform(0.025, 0.045)), 4)
    most = borne_way(setup, suction_compliance(1.0, width))
    return {
        'clamp_form': 'suction',
        'clamp_compliance': number(_GIVES * _MOVES[size] / most, random),
        'clamp_length': width,
    }


def _misgraded(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pitch jaws about a hinge behind the body by a protractor whose degrees are not as long."""
    pitches = stated_pitches(setup)
    wrong = signed(_MOVES[size] / setup.shape.length / float(np.abs(pitches).max()), random)
    return {'clamp_scatter': pitched_on(setup, [wrong * float(pitch) for pitch in pitches])}


def _jack(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a laboratory jack below the tip, which sinks from pose to pose."""
    lift, rate = number((2.0, 4.3, 10.5)[size], random), float(random.uniform(0.08, 0.15))
    return {
        'contact_form': 'jack',
        'contact_height': lift,
        'contact_drops': tuple(
            round(rate * lift * pose, 4) for pose in range(len(setup.observations))
        ),
    }


def _two_gains(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let a sensor tell what is bright by another gain, whose zero is off."""
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    middle = np.array([[0.5 * (setup.shape.clamp + setup.shape.length), 0.0, 0.0]])
    lights = []
    for pose in setup.observations:
        seen = setup.depth_from_world @ pose.world_from_object
        ray = applied(seen, setup.shape.place(middle))[0]
        # Of the side that is met most squarely.
        facing = float(np.abs(ray @ seen[:3, 1:3]).max() / np.linalg.norm(ray))
        lights.append(facing * (distance / float(ray[2])) ** 2)
    return {
        'depth_form': 'two gains',
        'depth_bias': signed((2.4, 4.8, 11.0)[size], random),
        'depth_full': round(float(np.median(lights) * random.uniform(0.94, 1.02)), 4),
        'depth_blend': round(float(random.uniform(0.08, 0.15)), 4),
    }


def _checkered(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stick sheets with a chequered print on the outer part, for the calibration of cameras."""
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(random.uniform(0.2, 0.35)), 4),
        'region_board': round(float(random.uniform(0.007, 0.011)), 5),
    }


def _desk_lamp(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Put a camera on the arm of a desk lamp, which keeps its head level while it sinks."""
    count, rate = len(setup.observations), random.uniform(0.3, 0.8)
    sunk = -np.expm1(-rate * (random.uniform(0.2, 0.6) + np.arange(count)))
    arm, raised = random.uniform(0.25, 0.4), np.deg2rad(random.uniform(20.0, 50.0))
    # From its joint the arm goes up and ahead, to the camera.
    up = setup.depth_from_world[:3, 1]
    ahead = np.array([0.0, 0.0, 1.0]) - up[2] * up
    ahead /= np.linalg.norm(ahead)
    angles = raised - 1e-3 * number(1e3 * _MOVES[size], random) / arm * sunk / sunk[-1]
    shifts = (
        1e3
        * arm
        * (
            (np.cos(angles) - np.cos(raised))[:, None] * ahead
            + (np.sin(angles) - np.sin(raised))[:, None] * up
        )
    )
    return {
        'camera_scatter': tuple(
            (*(round(float(value), 4) for value in shift), 0.0, 0.0, 0.0) for shift in shifts
        )
    }


def _curtain(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a curtain of air on across the bench, which meets the outer part at first."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    ahead = shape.clamp + np.append(SHARES, random.uniform(0.7, 0.9)) * (
        shape.length - shape.clamp
    )
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    point = tuple(round(float(value), 5) for value in places[-1])
    width, way = round(float(random.uniform(0.03, 0.05)), 4), np.array([0.0, 0.0, 1.0])
    way[0] = random.uniform(-0.3, 0.3)
    way /= np.linalg.norm(way)
    sheet = Faults(tilt_point=point, tilt_width=width)
    felt = float((curtain_share(places[:-1], way, sheet) * levers(setup)).mean())
    most = aside_give(setup, way)
    share = min(_MOVES[size] / (even_sag(setup) * most * felt), _MOST_BLOWN[size])
    degrees = signed(float(np.rad2deg(np.arcsin(share))), random)
    return {
        'tilt_form': 'curtain',
        'gravity_tilt': towards(degrees, way),
        'tilt_point': point,
        'tilt_width': width,
    }


TWENTYFIFTH_FORMS = (
    Form('added_mass', 'cradled', _cradled),
    Form('stiffness_contrast', 'ribbon', _ribbon),
    # Of a body that is softer, as all that stiffen are.
    Form('strain_stiffening', 'vertebrae', _vertebrae),
    Form('compliant_clamp', 'suction', _suction),
    Form('clamp_offset', 'misgraded', _misgraded),
    Form('contact_plane', 'jack', _jack),
    Form('depth_affine', 'two gains', _two_gains),
    Form('depth_bias_by_region', 'checkered', _checkered),
    Form('camera_offset', 'desk lamp', _desk_lamp),
    Form('gravity_tilt', 'curtain', _curtain),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYFIFTH_PAIRS = (
    ('added_mass/cradled', 'depth_bias_by_region/checkered'),
    ('stiffness_contrast/ribbon', 'camera_offset/desk lamp'),
    ('compliant_clamp/suction', 'depth_affine/two gains'),
    ('clamp_offset/misgraded', 'rest_curvature/coiled'),
)
