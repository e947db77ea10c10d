# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the thirty-second set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.breath import dried_reach
from benchmarks.blind.draught import wall_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import hexapod_compliance
from benchmarks.blind.form import Form
from benchmarks.blind.hourglass import outer_sand
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.pitching import key_turns, turned_on
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.sheets import sheet_value
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

_MOVES = (0.002, 0.004, 0.010)  # Of the tip, or what is seen to move most [m].
_BLOWN_MORE = 1.25  # By which that is drawn larger, as blown bodies turn from the air.
_MOST_LACKING = 5.0  # By which log E is less at the clamp.
_GIVES = 0.8  # Of a tip's way, what a spring has of it: a body that is turned bends on.
_MOST_BLOWN = (0.3, 0.6, 0.95)  # Of the weight, by which air blows where it is fastest.
_SOFTER = 0.3  # Of its modulus a body has where it is to be strained, as the generator has it.
_MOST_HELD = 0.55  # Of a body's sag, by which rovings lessen that.
_SIDE = 0.25  # Of the height, which rovings have.
_MOST_STIFF = 50.0  # E of rovings over that of rubber, were they along all of a side.
# A side is three times as wide as the rovings along both its edges, of which many are not taut.
_AT_EDGES = 5.0
_TAUT = ((0.1, 0.3), (0.8, 1.4))  # Where the first comes so, and all others, over what is drawn.


def _hourglass(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Lay an hourglass along a body, whose sand runs to the lower bulb all the time."""
    stops = tuple(round(float(random.uniform(*ends)), 4) for ends in ((0.15, 0.35), (0.85, 0.97)))
    flow = round(float(random.uniform(0.3, 0.45)), 4)
    glass, bulbs = Faults(mass_flow=flow), np.interp(stops, SHARES, levers(setup))
    # What is along the body moves no tip.
    most = 0.0
    for pose, each in enumerate(setup.observations):
        part = outer_sand(setup, glass, pose)
        steep = float(np.hypot(*each.world_from_object[1, 1:3]))
        most = max(most, 0.375 * steep * float(bulbs @ [1.0 - part, part]))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (most * GRAVITY)
    return {
        'mass_form': 'hourglass',
        'added_mass': number(grams, random),
        'mass_stops': stops,
        'mass_flow': flow,
    }


def _rolled_sheets(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Roll a body up from sheets of rubber, fewer of which reach as far as the clamp."""
    count = int(random.integers(4, 8))
    contrasts = np.linspace(0.0, -_MOST_LACKING, 101)
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    softer = np.exp(-contrasts[:, None] * sheet_value(SHARES, count))
    changes = even_sag(setup) * (softer - 1.0) @ parts
    return {
        'contrast_mode': 'rolled sheets',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
        'contrast_sheets': count,
    }


def _rovings(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Lay rovings of glass along the four edges, whose filaments are not all as long."""
    held = min(_MOVES[size] * _SOFTER / even_sag(setup), _MOST_HELD)
    stiff = _AT_EDGES * side_stiffness(held, _SIDE, _MOST_STIFF)
    begin, spread = (round(float(random.uniform(*ends)) * most_drawn(setup), 5) for ends in _TAUT)
    return {
        'stiffening_form': 'rovings',
        'stiffening': number(stiff, random),
        'stiffening_from': begin,
        'stiffening_spread': spread,
    }


def _hexapod(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stand a clamp on a hexapod of six soft legs, by which it is to be aligned."""
    height = round(float(random.uniform(0.05, 0.09)), 4)
    most = borne_way(setup, hexapod_compliance(1.0, height))
    return {
        'clamp_form': 'hexapod',
        'clamp_compliance': number(_GIVES * _MOVES[size] / most, random),
        'clamp_length': height,
    }


def _chuck_key(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Tighten one jaw of a chuck before each pose, the next one of the three each time."""
    angle = number(_MOVES[size] / setup.shape.length, random)
    first = random.uniform(0.0, 2.0 * np.pi)
    turns = key_turns(angle, first, len(setup.observations))
    return {'clamp_scatter': turned_on(setup, turns)}


def _breath(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Breathe on a sensor's window before the first pose, and let that dry."""
    shape, camera = setup.shape, setup.camera
    spot = random.uniform(-25.0, 25.0, 2)
    ends = shape.place(np.array([[shape.clamp, 0.0, 0.0], [shape.length, 0.0, 0.0]]))
    world = setup.depth_from_world @ setup.observations[0].world_from_object
    ways = camera.project(applied(world, ends)) - [camera.cx, camera.cy] - spot
    # At first it covers most of the body.
    reach = random.uniform(0.8, 0.95) * np.linalg.norm(ways, axis=1).max()
    dried = dried_reach(len(setup.observations), random.uniform(4.0, 5.5))
    return {
        'depth_form': 'breath',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_spot': (round(float(spot[0]), 3), round(float(spot[1]), 3)),
        'depth_places': tuple(round(float(value), 3) for value in reach * dried),
    }


def _flaking(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Paint a body with what flakes off where it bends, and most does so near the clamp."""
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(random.uniform(0.0, 0.15)), 4),
        'region_flakes': round(float(random.uniform(0.005, 0.008)), 5),
        'region_seed': int(random.integers(1 << 30)),
    }


def _sunlit_post(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stand a camera on a post that the sun warms on one side, which goes round with it."""
    world, count = setup.depth_from_world, len(setup.observations)
    half = 0.5 * random.uniform(0.3, 0.5)
    begin, goes = random.uniform(0.0, 360.0), random.uniform(15.0, 35.0)
    suns = np.deg2rad(begin + float(random.choice([-1.0, 1.0])) * goes * np.arange(count))
    # What is warm grows longer, so that the post's top leans away from the sun, as an arc does.
    axes = np.column_stack([-np.sin(suns), np.zeros(count), np.cos(suns)])
    warm = -np.expm1(-(np.arange(count) + random.uniform(0.3, 0.8)) / random.uniform(0.8, 2.0))
    camera = -world[:3, :3].T @ world[:3, 3]
    # About what is half as high, where the tangents of both ends of an arc meet.
    pivot = camera - [0.0, half, 0.0]
    most = (warm * np.linalg.norm(np.cross(axes, pivot), axis=1)).max()
    turn = number(float(np.rad2deg(_MOVES[size] / most)), random)
    turns = turn * warm[:, None] * axes @ world[:3, :3].T
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, *(round(float(value), 4) for value in each)) for each in turns
        ),
        'camera_foot': tuple(round(float(value), 4) for value in applied(world, pivot[None])[0]),
    }


def _wall_jet(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Blow along the wall that the clamp is screwed to, from which a body stands out."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    free = shape.length - shape.clamp
    ahead = np.append(shape.clamp + SHARES * free, random.uniform(0.0, 1.0) * shape.clamp)
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    way = np.array([random.uniform(-0.3, 0.3), 0.0, float(random.choice([-1.0, 1.0]))])
    way /= np.linalg.norm(way)
    point = tuple(round(float(value), 5) for value in places[-1])
    # Into the room, and to the body.
    outer = np.sign((places[-2] - places[-1]) @ np.cross(way, [0.0, 1.0, 0.0]))
    width = round(float(outer * random.uniform(0.45, 0.75) * free), 4)
    jet = Faults(tilt_point=point, tilt_width=width)
    felt = float((wall_share(places[:-1], way, jet) * levers(setup)).mean())
    whole = even_sag(setup) * aside_give(setup, way) * felt
    share = min(_BLOWN_MORE * _MOVES[size] / whole, _MOST_BLOWN[size])
    return {
        'tilt_form': 'wall jet',
        'gravity_tilt': towards(number(float(np.rad2deg(np.arcsin(share))), random), way),
        'tilt_point': point,
        'tilt_width': width,
    }


def _woven(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body woven through a grid, over one wire, below the next and over a third."""
    free = setup.shape.length - setup.shape.clamp
    first, apart = random.uniform(0.1, 0.16), random.uniform(0.28, 0.34)
    places = first + apart * np.arange(3) + random.uniform(-0.03, 0.03, 3)
    return {
        'curvature_form': 'woven',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_wires': tuple(round(float(place), 4) for place in places),
    }


THIRTYSECOND_FORMS = (
    Form('added_mass', 'hourglass', _hourglass),
    Form('stiffness_contrast', 'rolled sheets', _rolled_sheets),
    # Of a body that is softer, as all that stiffen are.
    Form('strain_stiffening', 'rovings', _rovings),
    Form('compliant_clamp', 'hexapod', _hexapod),
    Form('clamp_offset', 'chuck key', _chuck_key),
    Form('depth_affine', 'breath', _breath),
    Form('depth_bias_by_region', 'flaking', _flaking),
    Form('camera_offset', 'sunlit post', _sunlit_post),
    Form('gravity_tilt', 'wall jet', _wall_jet),
    Form('rest_curvature', 'woven', _woven),
)
# Two at a time, of different effects, each pair of effects once: new ones, and some that sets of
# before had singly.
THIRTYSECOND_PAIRS = (
    # Both of the body or what acts on it.
    ('added_mass/hourglass', 'compliant_clamp/hexapod'),
    ('strain_stiffening/rovings', 'clamp_offset/chuck key'),
    ('stiffness_contrast/rolled sheets', 'gravity_tilt/curtain'),
    ('rest_curvature/woven', 'clamp_offset/universal joint'),
    # One of these, one of the sensor.
    ('gravity_tilt/wall jet', 'depth_bias_by_region/flaking'),
    ('camera_offset/sunlit post', 'stiffness_contrast/baked'),
    ('depth_affine/breath', 'contact_plane/gel pad'),
    ('rest_curvature/woven', 'depth_bias_by_region/tongues'),
)
