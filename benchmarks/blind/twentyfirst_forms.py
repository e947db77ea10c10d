# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the twenty-first set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 4 and 10 mm, where the
mechanics allow it.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.moduli import soaked_share
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.slender import even_sag, levers, SHARES, softness
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_INNERMOST, _OUTERMOST = 0.3, 0.95  # Shares of the free length between which a lump oozes.
_MOST_SOAKED = 4.0  # By which log E fell at the surface of what was dipped.
_SLIPS = 0.15  # Of a tip's way by a leash, how far the clamp itself is drawn.
_MOST_BRAKED = 0.8  # Of the weight, by which a rig that is not yet at rest draws.
_PARTS = 7  # Of a body that was jumbled.
_MOST_BENT = 5.0  # Of such a part's bend over that of an arc.
_LEAST_ASIDE = 0.25  # Of the tip's way, by which somewhere it must be beside an arc.


def _oozing(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a lump of grease on a body, which oozes to where that points down."""
    at, rate = float(random.uniform(0.6, 0.75)), float(random.uniform(0.3, 0.45))
    places = []
    for pose in setup.observations:
        down = -float(pose.world_from_object[1, 0])
        at = float(np.clip(at + rate * down, _INNERMOST, _OUTERMOST))
        places.append(round(at, 4))
    # What is along the body moves no tip.
    across = [float(np.hypot(*pose.world_from_object[1, 1:3])) for pose in setup.observations]
    lever = float((np.array(across) * np.interp(places, SHARES, levers(setup))).max())
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / (0.375 * lever * GRAVITY)
    return {
        'mass_form': 'oozing',
        'added_mass': number(grams, random),
        'mass_places': tuple(places),
    }


def _soaked(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Dip a body into oil, which softens it from its surface inwards."""
    at = round(float(random.uniform(0.08, 0.2)), 4)
    depth = round(float(random.uniform(0.002, 0.0035)), 5)
    width, height = setup.shape.section
    ticks = (np.arange(20) + 0.5) / 20.0
    wide, high = np.meshgrid(0.5 * width * ticks, 0.5 * height * ticks)
    below = np.minimum(0.5 * width - wide, 0.5 * height - high)
    oil = soaked_share(np.ones(below.shape), below, at, depth)
    contrasts = np.linspace(0.0, -_MOST_SOAKED, 81)
    # Parts of a section bear by the square of their height.
    bears = (np.exp(contrasts[:, None, None] * oil) * high**2).sum(axis=(1, 2)) / (high**2).sum()
    dipped = float((1.0 - SHARES) ** 3 * softness(setup) / 50.0 @ (at < SHARES))
    changes = even_sag(setup) * dipped * (1.0 / bears - 1.0)
    # Of a few points across a section, those near its surface lie deeper than that.
    wanted = 1.3 * _MOVES[size]
    return {
        'contrast_mode': 'soaked',
        'contrast': -number(float(np.interp(wanted, changes, -contrasts)), random),
        'contrast_at': at,
        'contrast_depth': depth,
    }


def _hot_glue(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a body by a lump of hot glue, which lamps soften from pose to pose."""
    rate, last = random.uniform(0.4, 0.8), len(setup.observations) - 1
    turn = _MOVES[size] / (setup.shape.length - 0.5 * setup.shape.clamp)
    return {
        'clamp_form': 'hot glue',
        'clamp_compliance': number(turn / held_moment(setup), random),
        'clamp_shares': tuple(
            round(float(np.exp(-rate * (last - pose))), 4) for pose in range(last + 1)
        ),
    }


def _leashed(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let a stiff cable draw the outer end of a holder to one place of the room."""
    around, height = random.uniform(0.0, 2.0 * np.pi), random.uniform(-0.2, 0.4)
    anchor = np.array([0.5 * np.cos(around), height, 0.5 * np.sin(around)])
    end, ways = np.array([-0.02, 0.0, 0.0]), []
    for pose in setup.observations:
        away = anchor - applied(pose.world_from_object, end[None])[0]
        ways.append(pose.world_from_object[:3, :3].T @ away / np.linalg.norm(away))
    turns = np.cross([-1.0, 0.0, 0.0], ways)
    turns /= np.linalg.norm(turns, axis=1).max()
    way = setup.shape.length - 0.5 * setup.shape.clamp
    most = number(float(np.rad2deg(1.1 * _MOVES[size] / way)), random)
    shifts = 1e3 * _SLIPS * np.deg2rad(most) * way * np.array(ways)
    return {
        'clamp_scatter': tuple(
            tuple(round(float(value), 4) for value in (*shift, *turn))
            for shift, turn in zip(shifts, most * turns, strict=True)
        )
    }


def _hovering(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a table on that blows air from many holes, over which the tip hovers."""
    free, width = setup.shape.length - setup.shape.clamp, setup.shape.section[0]
    # Of the outer fifth, which is near to it.
    pressure = tip_stiffness(setup) * _MOVES[size] / (0.2 * free * width)
    return {
        'contact_form': 'hovering',
        'contact_height': number(1e3 * _MOVES[size], random),
        'contact_pressure': number(pressure, random),
        'contact_bend': round(float(random.uniform(0.0015, 0.0025)), 5),
    }


def _flared(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a body by blank jaws, whose light a dusty lens spreads over what is beside them."""
    return {
        'depth_form': 'flared',
        'depth_bias': signed((2.2, 4.4, 11.0)[size], random),
        'depth_width': round(float(random.uniform(50.0, 110.0)), 3),
    }


def _two_tone(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Paint a body white and black, whose depths err to either side."""
    return {
        'region_bias': signed((2.0, 4.2, 10.0)[size], random),
        'region_from': round(float(random.uniform(0.6, 0.75)), 4),
        'region_second': round(float(random.uniform(0.2, 0.35)), 4),
        'region_back': round(float(random.uniform(0.5, 0.9)), 4),
    }


def _hunting(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Let the head of a camera turn back too far each time it corrects where it looks."""
    most, calms = number((0.35, 0.7, 1.75)[size], random), random.uniform(0.7, 0.9)
    # Mostly to the side, about what stands below the lens.
    axis = random.uniform(-0.5, 0.5, 3) * np.array([1.0, 0.0, 0.4]) + np.array([0.0, 1.0, 0.0])
    turn = float(random.choice([-1.0, 1.0])) * most * axis / np.linalg.norm(axis)
    foot = (0.0, random.uniform(0.03, 0.05), random.uniform(-0.03, 0.0))
    return {
        'camera_scatter': tuple(
            (0.0, 0.0, 0.0, *(round(float(value), 4) for value in (-calms) ** pose * turn))
            for pose in range(len(setup.observations))
        ),
        'camera_foot': tuple(round(float(value), 4) for value in foot),
    }


def _braking(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Film a body while the arm that carries it still slows down from the pose before."""
    middle = np.array([[0.5 * setup.shape.length, 0.0, 0.0]])
    places = np.concatenate(
        [applied(pose.world_from_object, middle) for pose in setup.observations]
    )
    # It had been where it is first for long.
    steps = np.diff(places, axis=0, prepend=places[:1])
    section = np.array(setup.shape.section)
    # A body gives way across its sides by the inverse square of how thick it is that way.
    gives = (section.min() / section) ** 2
    moves = [
        np.linalg.norm(gives * (pose.world_from_object[:3, 1:3].T @ step))
        for step, pose in zip(steps, setup.observations, strict=True)
    ]
    rate = _MOVES[size] / (even_sag(setup) * float(max(moves)))
    most = _MOST_BRAKED / float(np.linalg.norm(steps, axis=1).max())
    pushes = number(GRAVITY * min(rate, most * _MOVES[size] / _MOVES[2]), random) * steps
    return {
        'tilt_form': 'braking',
        'tilt_pushes': tuple(tuple(round(float(value), 4) for value in push) for push in pushes),
    }


def _jumbled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Keep a body in a full drawer, where each part of it was bent its own way."""
    left = 1.0 - (np.arange(_PARTS) + 0.5) / _PARTS
    joints = np.arange(1.0, _PARTS) / _PARTS
    # How far each part's bend takes each joint between the parts.
    arms = np.maximum(joints[:, None] - (1.0 - left), 0.0) / _PARTS
    is_wanted = False
    while not is_wanted:
        bends = random.standard_normal(_PARTS) + 1j * random.standard_normal(_PARTS)
        # The tip is as far off as that of an arc, and the same way.
        bends *= 0.5 * _PARTS / (left @ bends)
        aside = np.abs(arms @ (bends - 1.0)).max() / 0.5
        is_wanted = bool(np.abs(bends).max() < _MOST_BENT and aside > _LEAST_ASIDE)
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'jumbled',
        'rest_curvature': direction(2.0 * _MOVES[size] / free**2, 2, random),
        'curvature_parts': tuple(
            (round(float(bend.real), 4), round(float(bend.imag), 4)) for bend in bends
        ),
    }


TWENTYFIRST_FORMS = (
    Form('added_mass', 'oozing', _oozing),
    Form('stiffness_contrast', 'soaked', _soaked),
    Form('compliant_clamp', 'hot glue', _hot_glue),
    Form('clamp_offset', 'leashed', _leashed),
    Form('contact_plane', 'hovering', _hovering),
    Form('depth_affine', 'flared', _flared),
    Form('depth_bias_by_region', 'two-tone', _two_tone),
    Form('camera_offset', 'hunting', _hunting),
    Form('gravity_tilt', 'braking', _braking),
    Form('rest_curvature', 'jumbled', _jumbled),
)
# Two at a time, of different effects: new ones, and one that a set of before had singly.
TWENTYFIRST_PAIRS = (
    ('added_mass/oozing', 'camera_offset/hunting'),
    ('stiffness_contrast/soaked', 'depth_affine/flared'),
    ('compliant_clamp/hot glue', 'depth_bias_by_region/two-tone'),
    ('rest_curvature/jumbled', 'contact_plane/cushion'),
)
