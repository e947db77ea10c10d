# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-third set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.flexure import gantry_compliance
from benchmarks.blind.form import apart, Form
from benchmarks.blind.moduli import edge_share
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import even_sag, levers, SHARES, softness, towards
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_SOFTENED = 5.0  # By which log E fell on the edges.
_GIVES = 0.85  # Of what a bar's own sag says, by how much a tip sinks by soft edges.
_TWISTS = 0.7  # Of a tip's way, which a crossbar's twist has: it bends as well.
_SOFTER = 0.3  # Of its modulus a body has where it is to be strained, as the generator has it.
_MOST_HELD = 0.4  # Of a body's sag on its side, by which leads lessen that.
_SLACK = (0.05, 0.15)  # Of what the leads of a sensor are drawn most by, how loose they are.
_SINKS = 0.0025  # By how much a body sinks into packing foam where it lies on that [m].
_MOST_TILTED = (0.12, 0.24, 0.4)  # Of the weight, by which a tilted trolley draws aside.

_LEAST_ASIDE = 0.8  # Of a trolley's lean, how much is across a body in one of the poses at least.


def _hung_on(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hang a clip with a label on a body, but not before the first pose or two."""
    at, first = round(float(random.uniform(0.7, 0.95)), 4), int(random.integers(1, 3))
    first = min(first, len(setup.observations) - 1)
    # What is along the body moves no tip.
    across = max(
        float(np.hypot(*pose.world_from_object[1, 1:3])) for pose in setup.observations[first:]
    )
    lever = 0.375 * across * float(np.interp(at, SHARES, levers(setup)))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (lever * GRAVITY)
    return {
        'mass_form': 'hung on',
        'added_mass': number(grams, random),
        'added_mass_at': at,
        'mass_from': first,
    }


def _edged(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast a body in a printed mould, whose resin keeps rubber from curing where walls meet."""
    contrasts, places = np.linspace(0.0, -_MOST_SOFTENED, 101), (np.arange(40) + 0.5) / 40.0
    edges = edge_share(places[:, None], places)
    # Parts of a section bear by the square of their height.
    bears = (np.exp(contrasts[:, None, None] * edges) @ places**2).mean(axis=1)
    sag = even_sag(setup) * float((1.0 - SHARES) ** 3 @ softness(setup)) / 50.0
    changes = _GIVES * sag * (bears[0] / bears - 1.0)
    return {
        'contrast_mode': 'edged',
        'contrast': -number(float(np.interp(_MOVES[size], changes, -contrasts)), random),
    }


def _leads(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast the leads of a sensor at the tip along both sides of a body, loose at first."""
    # By how much the square of a length grows at most near the surface of an even bar.
    free = setup.shape.length - setup.shape.clamp
    drawn = 4.0 * even_sag(setup) * min(setup.shape.section) / free**2
    # What a body sags on its side; leads of a times E hold 0.2 a / (1 + 0.35 a) of that, as tried.
    thin = min(setup.shape.section) / setup.shape.section[0]
    held = min(_MOVES[size] * _SOFTER / (even_sag(setup) * thin**2), _MOST_HELD)
    return {
        'stiffening_form': 'leads',
        'stiffening': number(held / (0.2 - 0.35 * held), random),
        'stiffening_from': round(float(random.uniform(*_SLACK)) * drawn, 5),
    }


def _gantry(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Clamp a body amid the crossbar of a gantry, which its weight twists."""
    length = round(float(random.uniform(0.15, 0.25)), 4)
    downs = -np.array([pose.world_from_object[1, :3] for pose in setup.observations])
    turns = np.cross([1.0, 0.0, 0.0], downs) @ gantry_compliance(1.0, length)[3:, 3:]
    most = float(np.linalg.norm(turns, axis=1).max())
    turn = _TWISTS * _MOVES[size] / (setup.shape.length - 0.5 * setup.shape.clamp)
    return {
        'clamp_form': 'gantry',
        'clamp_compliance': number(turn / (most * held_moment(setup)), random),
        'clamp_length': length,
    }


def _packing(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a slab of packing foam below the tip, whose cells buckle."""
    bend = round(float(random.uniform(0.001, 0.0016)), 5)
    free, width = setup.shape.length - setup.shape.clamp, setup.shape.section[0]
    # Of the outer fifth, which lies on it.
    pressure = tip_stiffness(setup) * _MOVES[size] / (0.2 * free * width)
    return {
        'contact_form': 'packing',
        'contact_height': number(1e3 * (_MOVES[size] + _SINKS), random),
        'contact_pressure': number(pressure / float(-np.expm1(-_SINKS / bend)), random),
        'contact_bend': bend,
    }


def _restarted(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Switch a sensor off and on before each pose, whose zero is another each time."""
    shares = apart(len(setup.observations), random.standard_normal)
    return {
        'depth_form': 'restarted',
        'depth_bias': signed((2.0, 4.0, 10.0)[size], random),
        'depth_shares': tuple(round(float(share), 4) for share in shares),
    }


def _brushed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Paint the outer part by hand, in strokes that each are as thick as the brush was full."""
    strokes = random.uniform(0.25, 1.0, int(random.integers(4, 8)))
    strokes[random.integers(len(strokes))] = 1.0
    return {
        'region_bias': signed((2.4, 5.0, 12.0)[size], random),
        'region_from': round(float(random.uniform(0.3, 0.6)), 4),
        'region_strokes': tuple(round(float(stroke), 2) for stroke in strokes),
    }


def _slider(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Move a camera aside on a slider between poses, and back by a scale that is hard to read."""
    # Mostly to the camera's right.
    axis = np.array([1.0, 0.0, 0.0]) + random.uniform(-0.35, 0.35, 3) * np.array([0.0, 1.0, 1.0])
    axis /= np.linalg.norm(axis)
    places = apart(len(setup.observations), lambda count: random.uniform(-1.0, 1.0, count))
    shifts = number((2.0, 4.0, 10.0)[size], random) * places[:, None] * axis
    return {
        'camera_scatter': tuple(
            (*(round(float(value), 4) for value in shift), 0.0, 0.0, 0.0) for shift in shifts
        ),
    }


def _deflating(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stand all on a trolley with a tyre that loses its air, fast at first."""
    rate = random.uniform(0.3, 0.8)
    shares = -np.expm1(-rate * (random.uniform(0.2, 0.6) + np.arange(len(setup.observations))))
    shares /= shares[-1]
    turns = [pose.world_from_object[:3, 1:3] for pose in setup.observations]
    way, reach = np.zeros(3), 0.0
    while reach < _LEAST_ASIDE:
        around = random.uniform(0.0, 2.0 * np.pi)
        way = np.array([np.cos(around), 0.0, np.sin(around)])
        reach = max(float(np.linalg.norm(turn.T @ way)) for turn in turns)
    section = np.array(setup.shape.section)
    # A body gives way across its sides by the inverse square of how thick it is that way.
    gives = (section.min() / section) ** 2
    most = max(
        share * float(np.linalg.norm(gives * (turn.T @ way)))
        for share, turn in zip(shares, turns, strict=True)
    )
    tilt = min(_MOVES[size] / (even_sag(setup) * most), _MOST_TILTED[size])
    degrees = number(float(np.rad2deg(tilt)), random)
    return {
        'tilt_form': 'deflating',
        'gravity_tilt': towards(degrees, way),
        'tilt_shares': tuple(round(float(share), 4) for share in shares),
    }


def _outweighed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body on a shelf, with its heavy holder over the edge."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'outweighed',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_at': round(float(random.uniform(0.35, 0.7)), 4),
    }


TWENTYTHIRD_FORMS = (
    Form('added_mass', 'hung on', _hung_on),
    Form('stiffness_contrast', 'edged', _edged),
    Form('strain_stiffening', 'leads', _leads),
    Form('compliant_clamp', 'gantry', _gantry),
    Form('contact_plane', 'packing', _packing),
    Form('depth_affine', 'restarted', _restarted),
    Form('depth_bias_by_region', 'brushed', _brushed),
    Form('camera_offset', 'slider', _slider),
    Form('gravity_tilt', 'deflating', _deflating),
    Form('rest_curvature', 'outweighed', _outweighed),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYTHIRD_PAIRS = (
    ('added_mass/hung on', 'depth_affine/restarted'),
    ('stiffness_contrast/edged', 'camera_offset/slider'),
    ('compliant_clamp/gantry', 'depth_bias_by_region/brushed'),
    ('rest_curvature/outweighed', 'clamp_offset/greased'),
)
