# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the fifteenth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.draught import stream_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.form import Form, stiffening_form
from benchmarks.blind.moduli import plug_share
from benchmarks.blind.outside_forms import tip_sag, tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_BLOWN = 0.8  # Of the weight, by which a draught presses on its axis.


def _plugged(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cast a cone of a softer or harder rubber into the root, as the boot of a cable has one."""
    at = round(float(random.uniform(0.6, 0.9)), 4)
    contrasts = np.linspace(0.0, float(random.choice([-2.5, 3.5])), 101)
    # Square rings of a section by what they add to its stiffness, where the cone has all or none.
    shares, outward = (np.arange(200) + 0.5) / 200.0, (np.arange(50) + 0.5) / 50.0
    within = plug_share(shares[:, None], outward, at) @ outward**3 / (outward**3).sum()
    stiffer = 1.0 + within * np.expm1(contrasts)[:, None]
    # By the tip's share of an even load's moments, (1 - share)^3; what shears adds to that.
    sags = (1.0 / stiffer) @ (1.0 - shares) ** 3 / 50.0
    changes = tip_sag(setup) * np.abs(sags - 1.0)
    return {
        'contrast_mode': 'plugged',
        'contrast': number(float(np.interp(0.85 * _MOVES[size], changes, contrasts)), random),
        'contrast_at': at,
    }


def _drained(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Dip a body in paint and hang it up by its clamp, so that most of it ends near the tip."""
    places = (np.arange(50) + 0.5) / 50.0
    lever = float(np.average(0.5 * places**2 * (3.0 - places), weights=np.sqrt(places)))
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / lever / 9.81
    return {'mass_form': 'drained', 'added_mass': number(grams, random)}


def _post(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Screw the clamp to a slender post, which bends and carries it aside as it turns it."""
    length = round(float(random.uniform(0.08, 0.14)), 4)
    # Half of what a level body asks: where the weight is across the post, that bends by more.
    turn = 0.5 * _MOVES[size] / (setup.shape.length - 0.5 * setup.shape.clamp)
    return {
        'clamp_form': 'post',
        'clamp_compliance': number(turn / held_moment(setup), random),
        'clamp_length': length,
    }


def _loosening(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave out a washer, so that a screw works itself loose faster and faster."""
    return {
        'clamp_shift': direction((1.2, 2.4, 6.0)[size], 3, random),
        'clamp_turn': direction((0.9, 1.8, 4.5)[size], 3, random),
        'clamp_growth': round(float(random.uniform(1.8, 2.6)), 4),
    }


def _knob(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a screw of the rig turned up below the outer part, with a round knob on its end."""
    share = round(float(random.uniform(0.6, 0.75)), 4)
    # A place inside the tip moves by less, but what is wide is tilted off the knob.
    return {
        'contact_form': 'knob',
        'contact_height': number(1.15e3 * _MOVES[size] * share**1.5, random),
        'contact_share': share,
    }


def _toed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Drop a stereo camera, one of whose imagers then looks inward and is rolled a little."""
    return {
        'depth_form': 'toed',
        'depth_bias': signed((1.6, 4.0, 9.5)[size], random),
        'depth_roll': signed(1.5, random),
    }


def _tilted_imager(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Glue an imager aslant behind its lens, where it is not in the middle any more either."""
    return {
        'imager_tilt': direction((0.06, 0.12, 0.25)[size], 2, random),
        'center_shift': direction((3.0, 6.5, 16.0)[size], 2, random),
    }


def _draught(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a ventilator on across the bench, whose stream meets the outer part at first."""
    shape, world = setup.shape, setup.observations[0].world_from_object
    shares = (np.arange(50) + 0.5) / 50.0
    ahead = shape.clamp + np.append(shares, random.uniform(0.6, 0.8)) * (
        shape.length - shape.clamp
    )
    places = applied(world, shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0])))
    point = tuple(round(float(value), 5) for value in places[-1])
    width, aslant = round(float(random.uniform(0.05, 0.08)), 4), random.uniform(-0.4, 0.4)
    stream = Faults(tilt_point=point, tilt_width=width)
    felt = stream_share(places[:-1], np.array([aslant, 0.0, 1.0]), stream)
    # The tip's way by a load at a place, over that by the whole weight: 3/8 of it at the tip.
    levers = 0.5 * shares**2 * (3.0 - shares) / 0.375
    share = _MOVES[size] / (tip_sag(setup) * float((felt * levers).mean()))
    across = signed(float(np.rad2deg(np.arcsin(min(share, _MOST_BLOWN)))), random)
    # About the world's x it blows across the body, about z along it.
    return {
        'tilt_form': 'draught',
        'gravity_tilt': (across, round(float(-across * aslant), 4)),
        'tilt_point': point,
        'tilt_width': width,
    }


def _buckled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body in a box that is too short for it, so that it buckles between two walls."""
    free = setup.shape.length - setup.shape.clamp
    curvature = direction(2.0 * _MOVES[size] / free**2, 2, random)
    return {'curvature_form': 'buckled', 'rest_curvature': curvature}


FIFTEENTH_FORMS = (
    Form('added_mass', 'drained', _drained),
    # Rubber that is strained little hardly stiffens: a tip moves by some 4 and 6 mm at most.
    stiffening_form('hart_smith', (2.0e3, 1.0e4, 6.0e4)),
    Form('stiffness_contrast', 'plugged', _plugged),
    Form('compliant_clamp', 'post', _post),
    Form('clamp_offset', 'loosening', _loosening),
    Form('contact_plane', 'knob', _knob),
    Form('depth_affine', 'toed', _toed),
    Form('camera_offset', 'tilted imager', _tilted_imager),
    Form('gravity_tilt', 'draught', _draught),
    Form('rest_curvature', 'buckled', _buckled),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
FIFTEENTH_PAIRS = (
    ('added_mass/drained', 'camera_offset/tilted imager'),
    ('clamp_offset/loosening', 'rest_curvature/buckled'),
    ('contact_plane/knob', 'depth_bias_by_region/banded'),
    ('gravity_tilt/draught', 'depth_affine/toed'),
)
