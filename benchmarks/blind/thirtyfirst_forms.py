# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the thirty-first set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import number, signed
from benchmarks.blind.draught import eddy_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import strap_compliance
from benchmarks.blind.form import Form
from benchmarks.blind.motor_heat import heated_share
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.slender import (
    aside_give,
    borne_way,
    even_sag,
    levers,
    SHARES,
    softness,
    towards,
)

_MOVES = (0.002, 0.004, 0.010)  # Of the tip, or what is seen to move most [m].
_BLOWN_MORE = 1.25  # By which that is drawn larger, as blown bodies turn from the air.
_MOST_HEATED = 5.0  # By which log E is less at the clamp.
_GIVES = 0.8  # Of a tip's way, what a spring has of it: a body that is turned bends on.
_MOST_BLOWN = (0.3, 0.6, 0.95)  # Of the weight, by which air blows far above an edge.
_MOST_BENT = 0.55  # Half the height over the radius to which a body is bent.
_SPREAD = 0.3  # Of a tripod's feet from its middle, over its height.


def _steep(setup: Setup) -> list[float]:
    """Return which share of gravity goes across a body in each pose."""
    return [float(np.hypot(*pose.world_from_object[1, 1:3])) for pose in setup.observations]


def _vine(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Wind a lead wire around the outer part of a body, as the leads of heaters are."""
    begin, turn = (round(float(random.uniform(*ends)), 4) for ends in ((0.2, 0.45), (0.3, 0.6)))
    wound = levers(setup)[np.searchsorted(SHARES, begin) :]
    # What is along the body moves no tip.
    lever = 0.375 * float(wound.mean()) * max(_steep(setup))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (lever * GRAVITY)
    return {
        'mass_form': 'vine',
        'added_mass': number(grams, random),
        'added_mass_at': begin,
        'mass_wind': turn * float(random.choice([-1.0, 1.0])),
        'mass_side': round(float(random.uniform(-180.0, 180.0)), 3),
    }


def _motor_heat(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let the motor that turns the clamp warm up from pose to pose."""
    width = round(float(random.uniform(0.2, 0.4)), 4)
    contrasts = np.linspace(0.0, -_MOST_HEATED, 101)
    parts, most = (1.0 - SHARES) ** 3 * softness(setup) / 50.0, np.zeros(len(contrasts))
    for pose, part in enumerate(_steep(setup)):
        softer = np.exp(-contrasts[:, None] * heated_share(SHARES, width, pose))
        most = np.maximum(most, part * even_sag(setup) * (softer - 1.0) @ parts)
    return {
        'contrast_mode': 'motor heat',
        'contrast': -number(float(np.interp(_MOVES[size], most, -contrasts)), random),
        'contrast_width': width,
    }


def _twisted_strap(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a clamp by a flat strap of steel that was twisted, so that it fits on a wall."""
    length = round(float(random.uniform(0.03, 0.06)), 4)
    most = borne_way(setup, strap_compliance(1.0, length))
    return {
        'clamp_form': 'twisted strap',
        'clamp_compliance': number(_GIVES * _MOVES[size] / most, random),
        'clamp_length': length,
    }


def _saddle(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a saddle below the tip, some way beside its middle."""
    ahead, aside = (round(float(value), 5) for value in random.uniform(-0.012, 0.012, 2))
    return {
        'contact_form': 'saddle',
        'contact_height': number(1e3 * _MOVES[size], random),
        'contact_ahead': ahead,
        'contact_at': aside,
        'contact_round': round(float(random.uniform(0.06, 0.12)), 5),
        # It rises across a body rather than along it.
        'contact_slant': round(float(random.uniform(55.0, 125.0)), 3),
    }


def _wiped(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Wipe a greasy window by an arm that does not reach all of it."""
    camera, shape = setup.camera, setup.shape
    angle = random.uniform(-60.0, 60.0) + float(random.choice([0.0, 180.0]))
    away = random.uniform(0.55, 0.8) * camera.width
    spot = away * np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
    # The edge goes through the body of the first pose.
    at = shape.clamp + random.uniform(0.35, 0.65) * (shape.length - shape.clamp)
    place = shape.place(np.array([[at, 0.0, 0.0]]))
    world = setup.depth_from_world @ setup.observations[0].world_from_object
    way = camera.project(applied(world, place))[0] - [camera.cx, camera.cy] - spot
    return {
        'depth_form': 'wiped',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_spot': (round(float(spot[0]), 3), round(float(spot[1]), 3)),
        'depth_width': round(float(np.linalg.norm(way)), 3),
    }


def _carpet(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stand a camera's tripod with one foot on a carpet, into which that sinks by and by."""
    world = setup.depth_from_world
    camera, tall = -world[:3, :3].T @ world[:3, 3], random.uniform(0.35, 0.6)
    ways = random.uniform(0.0, 2.0 * np.pi) + 2.0 / 3.0 * np.pi * np.arange(3)
    around = np.column_stack([np.cos(ways), np.zeros(3), np.sin(ways)])
    feet = camera + tall * (_SPREAD * around - [0.0, 1.0, 0.0])
    # About the line of both other feet, by the logarithm of the time.
    middle, axis = feet[1:].mean(axis=0), feet[2] - feet[1]
    axis /= np.linalg.norm(axis) * -np.sign(np.cross(axis, feet[0] - middle)[1])
    turn = number(float(np.rad2deg(_MOVES[size] / np.linalg.norm(np.cross(axis, middle)))), random)
    sunk = np.log1p(np.arange(len(setup.observations)) / random.uniform(0.3, 1.0))
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, *(round(float(value), 4) for value in part * world[:3, :3] @ axis))
            for part in turn * sunk / max(sunk[-1], 1e-9)
        ),
        'camera_foot': tuple(round(float(value), 4) for value in applied(world, middle[None])[0]),
    }


def _along(setup: Setup) -> list[FloatArray]:
    """Return where a straight body's middle line is in each pose, world [m], (200, 3) each."""
    shape = setup.shape
    ahead = shape.clamp + SHARES * (shape.length - shape.clamp)
    line = shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0]))
    return [applied(pose.world_from_object, line) for pose in setup.observations]


def _eddy(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a fan on behind a box, so that air comes back below the height of that."""
    lines, width = _along(setup), round(float(random.uniform(0.01, 0.02)), 4)
    way = np.array([random.uniform(-0.3, 0.3), 0.0, float(random.choice([-1.0, 1.0]))])
    way /= np.linalg.norm(way)
    edge = round(float(lines[0][:, 1].mean() - random.uniform(0.6, 1.2) * width), 5)
    air = Faults(tilt_point=(0.0, edge, 0.0), tilt_width=width)
    felt = max(abs(float((eddy_share(line, way, air) * levers(setup)).mean())) for line in lines)
    whole = even_sag(setup) * aside_give(setup, way) * felt
    share = min(_BLOWN_MORE * _MOVES[size] / whole, _MOST_BLOWN[size])
    return {
        'tilt_form': 'eddy',
        'gravity_tilt': towards(number(float(np.rad2deg(np.arcsin(share))), random), way),
        'tilt_point': air.tilt_point,
        'tilt_width': width,
    }


def _over_a_rod(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Store a body on a rod, with both ends taped down to the table."""
    at = round(float(random.uniform(0.42, 0.58)), 4)
    free, half = setup.shape.length - setup.shape.clamp, 0.5 * setup.shape.section[1]
    # A beam with both ends held is so much curved below its load.
    rate = 6.0 * _MOVES[size] / (free**2 * at * (1.0 - at))
    rate = min(number(rate, random), _MOST_BENT / half)
    return {
        'curvature_form': 'over a rod',
        'rest_curvature': (round(float(random.choice([-1.0, 1.0])) * rate, 4), 0.0),
        'curvature_at': at,
    }


THIRTYFIRST_FORMS = (
    Form('added_mass', 'vine', _vine),
    Form('stiffness_contrast', 'motor heat', _motor_heat),
    Form('compliant_clamp', 'twisted strap', _twisted_strap),
    Form('contact_plane', 'saddle', _saddle),
    Form('depth_affine', 'wiped', _wiped),
    Form('camera_offset', 'carpet', _carpet),
    Form('gravity_tilt', 'eddy', _eddy),
    Form('rest_curvature', 'over a rod', _over_a_rod),
)
# Two at a time, of different effects, each pair of effects once: new ones, and some that sets of
# before had singly.
THIRTYFIRST_PAIRS = (
    # Both of the body or what acts on it.
    ('added_mass/vine', 'contact_plane/saddle'),
    ('added_mass/vine', 'clamp_offset/homed'),
    ('compliant_clamp/twisted strap', 'rest_curvature/over a rod'),
    ('compliant_clamp/twisted strap', 'strain_stiffening/corded'),
    ('stiffness_contrast/motor heat', 'gravity_tilt/eddy'),
    ('contact_plane/saddle', 'stiffness_contrast/gated'),
    ('gravity_tilt/eddy', 'rest_curvature/burdened'),
    # One of these, one of the sensor.
    ('depth_affine/wiped', 'clamp_offset/eccentric'),
    ('depth_affine/wiped', 'added_mass/solder'),
    ('camera_offset/carpet', 'compliant_clamp/gooseneck'),
    ('camera_offset/carpet', 'gravity_tilt/curtain'),
    ('rest_curvature/over a rod', 'camera_offset/desk lamp'),
    ('stiffness_contrast/motor heat', 'depth_bias_by_region/dipped'),
    # Both of the sensor.
    ('camera_offset/carpet', 'depth_bias_by_region/checkered'),
)
