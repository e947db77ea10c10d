# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the thirtieth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.draught import hollow_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import hairpin_compliance
from benchmarks.blind.form import Form
from benchmarks.blind.guard import farthest_way
from benchmarks.blind.masses import spray_density
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.pitching import pitched_on, stated_pitches, tangent_errors
from benchmarks.blind.rotations import applied
from benchmarks.blind.seeping import seeped_share
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

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_BLOWN_MORE = 1.25  # By which that is drawn larger, as blown bodies turn from the air.
_MOST_SEEPED = 5.0  # By which log E is less at the clamp.
_GIVES = 0.8  # Of a tip's way, what a spring has of it: a body that is turned bends on.
_MOST_CRANKED = 3.0  # Way of a nut by a radian, over its distance from the hinge.
_SINKS = 0.003  # By how much a body sinks into rubber balls where it lies on those [m].
_MOST_BLOWN = (0.3, 0.6, 0.95)  # Of the weight, by which air blows on a fan's ring.


def _spray_can(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Spray a body that turns before a can which is held still."""
    at, high = (round(float(random.uniform(*ends)), 4) for ends in ((0.8, 1.0), (0.25, 0.45)))
    thick = spray_density(SHARES, at, high)
    # What is along the body moves no tip.
    most = max(float(np.hypot(*pose.world_from_object[1, 1:3])) for pose in setup.observations)
    lever = 0.375 * float(levers(setup) @ thick / thick.sum()) * most
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (lever * GRAVITY)
    return {
        'mass_form': 'spray can',
        'added_mass': number(grams, random),
        'added_mass_at': at,
        'mass_spray': high,
    }


def _seeped(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a body in jaws that are wet with oil, which seeps into it from there."""
    width = round(float(random.uniform(0.25, 0.6)), 4)
    contrasts = np.linspace(0.0, -_MOST_SEEPED, 101)
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    softer = np.exp(-contrasts[:, None] * seeped_share(SHARES, width))
    changes = even_sag(setup) * (softer - 1.0) @ parts
    return {
        'contrast_mode': 'seeped',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
        'contrast_width': width,
    }


def _hairpin(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a clamp by a rod that was bent to a hairpin, so that it fits on a short table."""
    length = round(float(random.uniform(0.03, 0.06)), 4)
    most = borne_way(setup, hairpin_compliance(1.0, length))
    return {
        'clamp_form': 'hairpin',
        'clamp_compliance': number(_GIVES * _MOVES[size] / most, random),
        'clamp_length': length,
    }


def _tangent_arm(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Pitch jaws by an arm that a nut on a straight screw pushes, as though that were an arc."""
    cranks, pitches = np.linspace(0.01, _MOST_CRANKED, 300), stated_pitches(setup)
    most = [np.abs(tangent_errors(pitches, crank)).max() for crank in cranks]
    crank = float(np.interp(number(_MOVES[size] / setup.shape.length, random), most, cranks))
    return {'clamp_scatter': pitched_on(setup, tangent_errors(pitches, crank))}


def _rubber_balls(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a tray of rubber balls below the tip."""
    bend = round(float(random.uniform(0.002, 0.004)), 5)
    free, width = setup.shape.length - setup.shape.clamp, setup.shape.section[0]
    # Of the outer fifth, which lies on them.
    pressure = tip_stiffness(setup) * _MOVES[size] / (0.2 * free * width)
    return {
        'contact_form': 'rubber balls',
        'contact_height': number(1e3 * (_MOVES[size] + _SINKS), random),
        'contact_pressure': number(pressure / (_SINKS / bend) ** 1.5, random),
        'contact_bend': bend,
    }


def _glued_window(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Glue a sensor's window that broke in two, with a bend along the seam."""
    across, down = random.uniform(-30.0, 30.0, 2)
    slant = round(float(random.uniform(-40.0, 40.0)), 3)
    return {
        'depth_form': 'glued window',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_spot': (round(float(across), 3), round(float(down), 3)),
        'depth_slant': slant,
        # How far off a body's end is at most.
        'depth_width': round(farthest_way(setup, (across, down), slant), 3),
    }


def _worn_edges(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Wear a coat off along the edges, by which people take hold of a body."""
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(random.uniform(0.05, 0.25)), 4),
        'region_edges': round(float(random.uniform(0.35, 0.5)), 4),
    }


def _gas_spring(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Carry a camera on a gas spring that leaks, so that it sinks less and less."""
    most, lasts = number(1e3 * _MOVES[size], random), random.uniform(0.8, 2.0)
    numbers = np.arange(len(setup.observations))
    sunk = most * np.expm1(-numbers / lasts) / np.expm1(-max(numbers[-1], 1) / lasts)
    upright = setup.depth_from_world[:3, 1]
    return {
        'camera_scatter': tuple(
            (*(round(float(value), 4) for value in -each * upright), 0.0, 0.0, 0.0)
            for each in sunk
        )
    }


def _hub(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a fan on across the bench whose hub stands before the clamp's end of a body."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    free, behind = shape.length - shape.clamp, float(random.uniform(0.1, 0.35))
    ahead = shape.clamp + np.append(SHARES, behind) * free
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    way = np.array([random.uniform(-0.3, 0.3), 0.0, float(random.choice([-1.0, 1.0]))])
    way /= np.linalg.norm(way)
    point = tuple(round(float(value), 5) for value in places[-1])
    # The ring meets the outer part.
    width = round(float(random.uniform(0.8, 1.0) - behind) * free, 4)
    stream = Faults(tilt_point=point, tilt_width=width)
    felt = float((hollow_share(places[:-1], way, stream) * levers(setup)).mean())
    whole = even_sag(setup) * aside_give(setup, way) * felt
    share = min(_BLOWN_MORE * _MOVES[size] / whole, _MOST_BLOWN[size])
    return {
        'tilt_form': 'hub',
        'gravity_tilt': towards(number(float(np.rad2deg(np.arcsin(share))), random), way),
        'tilt_point': point,
        'tilt_width': width,
    }


def _slots(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Store a body with both ends in slots that lie beside each other."""
    free = setup.shape.length - setup.shape.clamp
    curvature = direction(2.0 * _MOVES[size] / free**2, 2, random)
    return {'curvature_form': 'slots', 'rest_curvature': curvature}


THIRTIETH_FORMS = (
    Form('added_mass', 'spray can', _spray_can),
    Form('stiffness_contrast', 'seeped', _seeped),
    Form('compliant_clamp', 'hairpin', _hairpin),
    Form('clamp_offset', 'tangent arm', _tangent_arm),
    Form('contact_plane', 'rubber balls', _rubber_balls),
    Form('depth_affine', 'glued window', _glued_window),
    Form('depth_bias_by_region', 'worn edges', _worn_edges),
    Form('camera_offset', 'gas spring', _gas_spring),
    Form('gravity_tilt', 'hub', _hub),
    Form('rest_curvature', 'slots', _slots),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
THIRTIETH_PAIRS = (
    ('added_mass/spray can', 'compliant_clamp/hairpin'),
    ('rest_curvature/slots', 'depth_affine/glued window'),
    ('clamp_offset/tangent arm', 'camera_offset/gas spring'),
    ('gravity_tilt/hub', 'strain_stiffening/corded'),
)
