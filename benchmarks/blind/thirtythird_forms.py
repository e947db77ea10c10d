# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the thirty-third set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.draught import spread_out
from benchmarks.blind.faults import Faults
from benchmarks.blind.form import Form
from benchmarks.blind.harness import wires_share
from benchmarks.blind.heat_gun import spread_heat
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.pitching import belt_errors, pitched_on, stated_pitches
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import (
    aside_give,
    even_sag,
    levers,
    SHARES,
    softness,
    towards,
)

_MOVES = (0.002, 0.004, 0.010)  # Of the tip, or what is seen to move most [m].
_BLOWN_MORE = 1.25  # By which that is drawn larger, as blown bodies turn from the air.
_MOST_HEATED = 5.0  # By which log E is less before a heat gun.
_MOST_BLOWN = (0.3, 0.6, 0.95)  # Of the weight, by which air blows where it is fastest.


def _steep(setup: Setup) -> list[float]:
    """Return which share of gravity goes across a body in each pose."""
    return [float(np.hypot(*pose.world_from_object[1, 1:3])) for pose in setup.observations]


def _harness(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Lay a harness along a body, one wire of which ends at each of its gauges."""
    count = int(random.integers(3, 6))
    ends = np.linspace(random.uniform(0.3, 0.5), random.uniform(0.9, 0.98), count)
    gauges = tuple(round(float(end), 4) for end in ends)
    wires = wires_share(SHARES, gauges)
    # What is along the body moves no tip.
    lever = 0.375 * float(levers(setup) @ wires / wires.sum()) * max(_steep(setup))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (lever * GRAVITY)
    return {
        'mass_form': 'harness',
        'added_mass': number(grams, random),
        'mass_gauges': gauges,
    }


def _heat_gun(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Dry some glue on a body by a heat gun before the first pose."""
    at, width, wider = (
        round(float(random.uniform(*ends)), 4) for ends in ((0.1, 0.3), (0.1, 0.16), (0.3, 0.6))
    )
    contrasts = np.linspace(0.0, -_MOST_HEATED, 101)
    parts, most = (1.0 - SHARES) ** 3 * softness(setup) / 50.0, np.zeros(len(contrasts))
    for pose, part in enumerate(_steep(setup)):
        softer = np.exp(-contrasts[:, None] * spread_heat(SHARES, at, width, wider, pose))
        most = np.maximum(most, part * even_sag(setup) * (softer - 1.0) @ parts)
    return {
        'contrast_mode': 'heat gun',
        'contrast': -number(float(np.interp(_MOVES[size], most, -contrasts)), random),
        'contrast_at': at,
        'contrast_width': width,
        'contrast_wider': wider,
    }


def _rim(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a bucket below the tip, which hangs over its rim."""
    ring = round(float(random.uniform(0.030, 0.045)), 5)
    # The tip is within the bucket, which stands ahead of it or a little aside.
    ahead = float(np.sign(setup.observations[0].world_from_object[0, 0]))
    slant, off = np.deg2rad(random.uniform(-30.0, 30.0)), random.uniform(0.5, 0.75) * ring
    return {
        'contact_form': 'rim',
        'contact_height': number(1e3 * _MOVES[size], random),
        'contact_ahead': round(float(off * ahead * np.cos(slant)), 5),
        'contact_at': round(float(off * np.sin(slant)), 5),
        'contact_ring': ring,
        'contact_round': round(float(random.uniform(0.010, 0.016)), 5),
    }


def _belt(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pitch jaws by a belt that slips by a share of each turn, to the side of the weight."""
    slips = belt_errors(stated_pitches(setup))
    lost = number(
        _MOVES[size] / (setup.shape.length * max(float(np.abs(slips).max()), 1e-9)), random
    )
    return {'clamp_scatter': pitched_on(setup, lost * slips)}


def _sealed_window(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a sensor's sealed housing on for hours, whose warm air bulges the window."""
    spot = random.uniform(-40.0, 40.0, 2)
    return {
        'depth_form': 'sealed window',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_spot': (round(float(spot[0]), 3), round(float(spot[1]), 3)),
        'depth_width': round(float(random.uniform(0.36, 0.48)) * setup.camera.width, 3),
    }


def _barcode(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Glue a label with a bar code around a body, whose dark bars a sensor sees elsewhere."""
    begin, end = random.uniform(0.02, 0.12), random.uniform(0.94, 1.0)
    # Bars and what is between them in turn, a bar first and last, of one to four modules each.
    modules = np.append(0, np.cumsum(random.integers(1, 5, 2 * int(random.integers(5, 8)) + 1)))
    borders = begin + (end - begin) * modules / modules[-1]
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(begin), 4),
        'region_bars': tuple(round(float(border), 4) for border in borders),
    }


def _downwash(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Blow down on the bench beside a body, where air spreads to all sides."""
    shape = setup.shape
    ahead = shape.clamp + SHARES * (shape.length - shape.clamp)
    line = shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0]))
    way = np.array([random.uniform(-0.3, 0.3), 0.0, float(random.choice([-1.0, 1.0]))])
    way /= np.linalg.norm(way)
    off = random.uniform(0.18, 0.3)
    point = tuple(round(float(-off * part), 5) for part in way)
    width = round(float(random.uniform(0.7, 1.2) * off), 4)
    air = Faults(tilt_point=point, tilt_width=width)
    felt = [
        float(
            (
                spread_out(applied(pose.world_from_object, line), way, air) @ way * levers(setup)
            ).mean()
        )
        for pose in setup.observations
    ]
    whole = even_sag(setup) * aside_give(setup, way) * max(felt)
    share = min(_BLOWN_MORE * _MOVES[size] / whole, _MOST_BLOWN[size])
    return {
        'tilt_form': 'downwash',
        'gravity_tilt': towards(number(float(np.rad2deg(np.arcsin(share))), random), way),
        'tilt_point': point,
        'tilt_width': width,
    }


def _wrapped(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep the inner half of a body wrapped around a square post."""
    free = setup.shape.length - setup.shape.clamp
    places = random.uniform(0.06, 0.12) + random.uniform(0.13, 0.2) * np.arange(3)
    return {
        'curvature_form': 'wrapped',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_corners': tuple(round(float(place), 4) for place in places),
    }


THIRTYTHIRD_FORMS = (
    Form('added_mass', 'harness', _harness),
    Form('stiffness_contrast', 'heat gun', _heat_gun),
    Form('contact_plane', 'rim', _rim),
    Form('clamp_offset', 'belt', _belt),
    Form('depth_affine', 'sealed window', _sealed_window),
    Form('depth_bias_by_region', 'barcode', _barcode),
    Form('gravity_tilt', 'downwash', _downwash),
    Form('rest_curvature', 'wrapped', _wrapped),
)
# Two at a time, of different effects, no effect twice: new ones, and some that sets of before had
# singly.
THIRTYTHIRD_PAIRS = (
    # Both of the body or what acts on it.
    ('gravity_tilt/downwash', 'compliant_clamp/hexapod'),
    ('rest_curvature/wrapped', 'clamp_offset/chuck key'),
    # One of these, one of the sensor.
    ('added_mass/harness', 'camera_offset/sunlit post'),
    ('stiffness_contrast/heat gun', 'depth_bias_by_region/barcode'),
    ('contact_plane/rim', 'depth_affine/breath'),
)
