# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the sixteenth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.draught import layer_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.form import Form, stiffening_form
from benchmarks.blind.moduli import pour_value
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.slender import even_sag, levers, SHARES, softness
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_BLOWN = 0.8  # Of the weight, by which air presses where the camera looks.
_POURS = 5
_LEAST_POURED = 0.3  # Of the worst cup's error, what is left in the mean of what bends a body.
_MOST_POURED = 2.2  # Log of a pour's modulus over that of a cup that was mixed well.
_UP = np.array([0.0, 1.0, 0.0])


def _pours(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Fill a mould from several cups, each of which was mixed more or less well."""
    contrasts = np.linspace(0.0, _MOST_POURED, 101)
    # By the tip's share of an even load's moments, (1 - share)^3, a part is stiffer by exp(c).
    parts = (1.0 - SHARES) ** 3 * softness(setup) / 50.0
    wanted, is_seen = _MOVES[size], False
    while not is_seen:
        errors = random.standard_normal(_POURS)
        # E is their mean; the worst cup has all of the contrast.
        errors -= errors.mean()
        values = tuple(round(float(error), 4) for error in errors / np.abs(errors).max())
        harder = pour_value(SHARES, values)
        sags = even_sag(setup) * np.exp(-contrasts[:, None] * harder) @ parts
        changes = np.maximum.accumulate(np.abs(sags - sags[0]))
        # Cups whose errors cancel are not seen.
        is_seen = changes[-1] > wanted and abs(harder @ parts) > _LEAST_POURED * parts.sum()
    return {
        'contrast_mode': 'pours',
        'contrast': number(float(np.interp(wanted, changes, contrasts)), random),
        'contrast_pours': values,
    }


def _angle_iron(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold the clamp by an angle iron, which bends aside of the load on it."""
    # Less than the formula asks of a clamp that turns: the iron's end is shifted as well.
    turn = 0.6 * _MOVES[size] / (setup.shape.length - 0.5 * setup.shape.clamp)
    return {
        'clamp_form': 'angle iron',
        'clamp_compliance': number(turn / held_moment(setup), random),
        'clamp_length': round(float(random.uniform(0.05, 0.09)), 4),
        # Its legs stand upright and level, or nearly so.
        'clamp_slant': signed(45.0, random),
    }


def _shaken(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a clamp so loose that it slips by as much as the rig is turned between poses."""
    amounts = direction((1.4, 2.7, 6.6)[size], 3, random)
    amounts += direction((1.0, 2.0, 5.0)[size], 3, random)
    turns = [pose.world_from_object[:3, :3] for pose in setup.observations]
    ways = [0.0, *(_angle(new @ old.T) for old, new in pairwise(turns))]
    through = np.cumsum(ways) / max(sum(ways), 1e-9)
    return {
        'clamp_scatter': tuple(
            tuple(round(float(share * amount), 4) for amount in amounts) for share in through
        )
    }


def _angle(turn: FloatArray) -> float:
    """Return by how much a rotation matrix turns [rad]."""
    return float(np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)))


def _brush(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a brush below the tip, whose bristles bend over, and then press no more."""
    bend = round(float(random.uniform(0.002, 0.003)), 5)
    free, width = setup.shape.length - setup.shape.clamp, setup.shape.section[0]
    # Of the outer fifth, what is pressed in most; a body comes down aslant.
    pressure = tip_stiffness(setup) * _MOVES[size] / (0.3 * 0.2 * free * width)
    return {
        'contact_form': 'brush',
        'contact_height': number(1e3 * (0.85 * _MOVES[size] + bend), random),
        'contact_pressure': number(pressure, random),
        'contact_bend': bend,
    }


def _smudge(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a drop of grease on a sensor's window, which holds back the light that goes by."""
    return {
        'depth_form': 'smudge',
        'depth_bias': signed((2.2, 4.4, 11.0)[size], random),
        'depth_spot': direction(float(random.uniform(25.0, 60.0)), 2, random),
        'depth_width': round(float(random.uniform(80.0, 120.0)), 3),
    }


def _wound(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Wind a tape around the outer part, which throws more light back than the rubber."""
    return {
        'region_bias': signed((2.0, 4.2, 10.0)[size], random),
        'region_from': round(float(random.uniform(0.3, 0.4)), 4),
        'region_bands': (
            round(float(random.uniform(0.28, 0.38)), 4),
            round(float(random.uniform(0.45, 0.6)), 4),
        ),
        'region_wound': True,
    }


def _swayed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hang the camera from the frame that turns the rig, and leans to that one's heavy side."""
    around = random.uniform(0.0, 2.0 * np.pi)
    heavy = np.array([0.0, np.cos(around), np.sin(around)])
    lean = number((0.2, 0.45, 1.1)[size], random)
    foot = (random.uniform(-0.03, 0.03), random.uniform(0.25, 0.35), random.uniform(-0.05, 0.0))
    look, found = setup.depth_from_world[:3, :3], []
    for observation in setup.observations:
        # What is level of the heavy side's way: a frame leans by the moment about its foot.
        turn = lean * look @ np.cross(_UP, observation.world_from_object[:3, :3] @ heavy)
        found.append((0.0, 0.0, 0.0, *(round(float(value), 4) for value in turn)))
    return {
        'camera_scatter': tuple(found),
        'camera_foot': tuple(round(float(value), 4) for value in foot),
    }


def _layer(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a window open, so that air moves over the bench, which slows it down."""
    above = round(float(random.uniform(0.075, 0.11)), 4)
    shape, aslant = setup.shape, random.uniform(-0.4, 0.4)
    way, stream = np.array([aslant, 0.0, 1.0]), Faults(tilt_above=above)
    ahead = shape.clamp + SHARES * (shape.length - shape.clamp)
    line = shape.place(ahead[:, None] * np.array([1.0, 0.0, 0.0]))
    felt = [
        layer_share(applied(pose.world_from_object, line), way, stream)
        for pose in setup.observations
    ]
    share = _MOVES[size] / (even_sag(setup) * float((np.array(felt) * levers(setup)).mean()))
    across = signed(float(np.rad2deg(np.arcsin(min(share, _MOST_BLOWN)))), random)
    # About the world's x it blows across the body, about z along it.
    return {
        'tilt_form': 'layer',
        'gravity_tilt': (across, round(float(-across * aslant), 4)),
        'tilt_above': above,
    }


def _folded(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Fold a body like a letter, one way and then back."""
    inner, outer, back = (
        round(float(random.uniform(*ends)), 4) for ends in ((0.2, 0.35), (0.6, 0.75), (0.5, 0.9))
    )
    free = setup.shape.length - setup.shape.clamp
    lever = (1.0 - inner) - back * (1.0 - outer)
    return {
        'curvature_form': 'folded',
        'rest_curvature': direction(_MOVES[size] / (lever * free**2), 2, random),
        'curvature_at': inner,
        'curvature_again': outer,
        'curvature_back': back,
    }


SIXTEENTH_FORMS = (
    # Of a body that is softer, as all that stiffen are.
    stiffening_form('beaded', (0.3, 1.0, 4.0)),
    Form('stiffness_contrast', 'pours', _pours),
    Form('compliant_clamp', 'angle iron', _angle_iron),
    Form('clamp_offset', 'shaken', _shaken),
    Form('contact_plane', 'brush', _brush),
    Form('depth_affine', 'smudge', _smudge),
    Form('depth_bias_by_region', 'wound', _wound),
    Form('camera_offset', 'swayed', _swayed),
    Form('gravity_tilt', 'layer', _layer),
    Form('rest_curvature', 'folded', _folded),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
SIXTEENTH_PAIRS = (
    ('compliant_clamp/angle iron', 'camera_offset/swayed'),
    ('contact_plane/brush', 'depth_affine/smudge'),
    ('gravity_tilt/layer', 'clamp_offset/shaken'),
    ('rest_curvature/folded', 'added_mass/drained'),
)
