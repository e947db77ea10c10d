# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the nineteenth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.marbling import marbled_value
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.slender import even_sag, levers, SHARES, softness
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_BORNE = 0.4  # Of a slung cable's weight, what draws across a level body.
_MOST_MARBLED = 1.1  # Standard deviation of log E in a rubber that was hardly stirred.
_GLUE_GIVES = 0.5  # Of the height: by so much more than its free part a glued body bends.
_LEAST_OFF, _MOST_OFF = 0.02, 0.5  # Of the held section, where glue came off.
_STICKS = 0.3  # Share of the weight that must be across a slot's walls for a body to go there.


def _slung(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let the cable of a sensor near the tip hang slack from there to the fixture."""
    at = round(float(random.uniform(0.85, 0.95)), 4)
    lever = float(np.interp(at, SHARES, levers(setup)))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * lever * _BORNE * GRAVITY)
    width, height = setup.shape.section
    # Plugged in on the fixture's upper side, to one side of it.
    anchor = np.array([0.5 * setup.shape.clamp, 0.5 * width, 0.5 * height + 0.006])
    anchor = 1e3 * anchor * np.array([1.0, random.uniform(-1.0, 1.0), 1.0])
    return {
        'mass_form': 'slung',
        'added_mass': number(grams, random),
        'added_mass_at': at,
        'mass_anchor': tuple(round(float(value), 3) for value in anchor),
        'mass_longer': round(float(random.uniform(0.25, 0.5)), 4),
    }


def _coils(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast a spring into a body near its surface, whose coils touch where it is bent enough."""
    return {
        'stiffening_form': 'coils',
        'stiffening': number((0.4, 1.2, 5.0)[size], random),
        'stiffening_from': round(float(random.uniform(0.015, 0.035)), 4),
    }


def _marbled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stir the two parts of a rubber too little before they are poured."""
    wave = round(float(random.uniform(0.4, 0.8)), 4)
    contrasts, wanted = np.linspace(0.0, _MOST_MARBLED, 41), _MOVES[size]
    is_seen = False
    while not is_seen:
        seed = int(random.integers(1, 2**31))
        changes = np.maximum.accumulate(np.abs(_marbled_moves(setup, contrasts, wave, seed)))
        # Swirls that cancel are not seen.
        is_seen = changes[-1] > wanted
    return {
        'contrast_mode': 'marbled',
        'contrast': number(float(np.interp(wanted, changes, contrasts)), random),
        'contrast_wave': wave,
        'contrast_seed': seed,
    }


def _marbled_moves(setup: Setup, contrasts: FloatArray, wave: float, seed: int) -> FloatArray:
    """Return by how much farther a tip sags by its weight for swirls' contrasts [m], (K,)."""
    ticks = (np.arange(6) + 0.5) / 3.0 - 1.0
    along, wide, high = np.meshgrid(SHARES, ticks, ticks, indexing='ij')
    harder = marbled_value(along, np.array([wide, high]), wave, seed)
    # Parts of a section bear by the square of their height; about where nothing is drawn.
    found = []
    for contrast in contrasts:
        stiff = np.exp(contrast * harder)
        whole, first, second = ((stiff * high**power).sum(axis=(1, 2)) for power in range(3))
        found.append((second - first**2 / whole) / (high[0] ** 2).sum())
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    return np.asarray(even_sag(setup) * (1.0 / np.array(found) - 1.0) @ parts)


def _glued(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Glue a body to its holder by the lower face alone, where it came off near the edge."""
    clamp, free = setup.shape.clamp, setup.shape.length - setup.shape.clamp
    low, high = sorted(setup.shape.section)
    bends = setup.youngs_modulus * high * low**3 / 12.0
    gapes = clamp * np.linspace(_LEAST_OFF, _MOST_OFF, 101)
    moment = held_moment(setup)
    force = moment / (0.5 * setup.shape.length)
    moment -= 0.5 * force * clamp
    # What is not held, and where it bends on beyond the glue's edge.
    loose = gapes + _GLUE_GIVES * setup.shape.section[1]
    turns = (moment * loose + 0.5 * force * loose**2) / bends
    shifts = (0.5 * moment * loose**2 + force * loose**3 / 3.0) / bends
    gape = float(np.interp(_MOVES[size], shifts + turns * free, gapes))
    return {
        'clamp_form': 'glued',
        'clamp_gape': min(number(1e3 * gape, random), round(1e3 * _MOST_OFF * clamp, 5)),
    }


def _rattling(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Print the slot for a body too wide, so that its weight tips it against the slot's walls."""
    way = setup.shape.length - 0.5 * setup.shape.clamp
    # Where it leans against two walls it is tipped by more.
    turns = [number(float(np.rad2deg(0.85 * _MOVES[size] / way)), random) for _ in range(2)]
    leaning, found = np.zeros(2), []
    for pose in setup.observations:
        down = -pose.world_from_object[1, 1:3]
        # It stays where it was as long as its weight presses it against other walls.
        leaning = np.where(np.abs(down) > _STICKS, np.sign(down), leaning)
        y, z = leaning * turns
        found.append((0.0, 0.0, 0.0, 0.0, float(-z), float(y)))
    return {'clamp_scatter': tuple(found)}


def _flap(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a box open below the tip, whose flap turns down under what lies on it."""
    away, sinks = round(signed(0.085, random), 4), random.uniform(0.3, 0.5)
    give = sinks / (1.0 - sinks) / tip_stiffness(setup) / away**2
    return {
        'contact_form': 'flap',
        'contact_height': number(1e3 * _MOVES[size] / (1.0 - sinks), random),
        'contact_ahead': away,
        'contact_give': number(give, random),
    }


def _exposed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let a sensor choose how long it exposes a frame, on which its zero depends."""
    return {'depth_form': 'exposed', 'depth_bias': signed((1.5, 3.2, 8.0)[size], random)}


def _soiled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Handle a body by its tip, where what fingers leave is thickest."""
    return {
        'region_bias': signed((2.0, 4.2, 10.5)[size], random),
        'region_decay': round(float(random.uniform(0.3, 0.6)), 4),
    }


def _framed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let a camera follow what it films by cutting out another part of its image each time."""
    shape, camera = setup.shape, setup.camera
    middle = shape.place(np.array([[0.5 * (shape.clamp + shape.length), 0.0, 0.0]]))
    away = np.array(
        [
            camera.project(applied(setup.depth_from_world @ pose.world_from_object, middle))[0]
            for pose in setup.observations
        ]
    ) - np.array([camera.cx, camera.cy])
    largest = float(np.linalg.norm(away, axis=1).max())
    # At 1 the body's middle comes to lie in the image's.
    gain = min(number((3.5, 7.0, 17.5)[size], random) / largest, 1.0)
    return {
        'center_scatter': tuple(
            tuple(round(float(value), 3) for value in -gain * place) for place in away
        )
    }


def _wavy(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Store a body on ridges, as of a sheet of packing foam, until it has taken their waves."""
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'wavy',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_waves': round(float(random.uniform(1.2, 2.4)), 4),
    }


NINETEENTH_FORMS = (
    Form('added_mass', 'slung', _slung),
    # Of a body that is softer, as all that stiffen are.
    Form('strain_stiffening', 'coils', _coils),
    Form('stiffness_contrast', 'marbled', _marbled),
    Form('compliant_clamp', 'glued', _glued),
    Form('clamp_offset', 'rattling', _rattling),
    Form('contact_plane', 'flap', _flap),
    Form('depth_affine', 'exposed', _exposed),
    Form('depth_bias_by_region', 'soiled', _soiled),
    Form('camera_offset', 'framed', _framed),
    Form('rest_curvature', 'wavy', _wavy),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
NINETEENTH_PAIRS = (
    ('added_mass/slung', 'camera_offset/framed'),
    ('compliant_clamp/glued', 'depth_affine/exposed'),
    ('contact_plane/flap', 'depth_bias_by_region/soiled'),
    ('rest_curvature/wavy', 'gravity_tilt/fan'),
)
