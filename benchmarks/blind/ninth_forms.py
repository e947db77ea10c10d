# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the ninth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 5 and 10 mm.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed, weight_moment
from benchmarks.blind.form import drawn_form, Form
from benchmarks.blind.moduli import DECAY
from benchmarks.blind.outside_forms import tip_sag, tip_stiffness
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.005, 0.010)  # Of the tip [m], by the formulas of a slender beam.


def _decentred(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Move an element of a barrel-shaped lens aside, which moves the image's middle along."""
    middle = direction((4.0, 8.0, 16.0)[size], 2, random)
    amount = number((0.02, 0.04, 0.08)[size], random) / float(np.linalg.norm(middle))
    return {
        'center_shift': middle,
        'tangential': (round(amount * middle[1], 5), round(amount * middle[0], 5)),
        'radial_distortion': -number((0.05, 0.1, 0.2)[size], random),
    }


def _flexure(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    _, moment = weight_moment(setup)
    # The moment at the held section's middle, and the force across, add to that at the face.
    compliance = float(np.deg2rad((0.8, 2.0, 4.0)[size])) / moment
    return {
        'clamp_form': 'flexure',
        'clamp_compliance': number(compliance, random),
        'clamp_length': round(float(random.uniform(0.015, 0.03)), 4),
    }


def _kink(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Fold a body a little where it was bent over in its box."""
    at = round(float(random.uniform(0.25, 0.5)), 4)
    free = setup.shape.length - setup.shape.clamp
    return {
        'curvature_form': 'kink',
        'rest_curvature': direction(_MOVES[size] / ((1.0 - at) * free**2), 2, random),
        'curvature_at': at,
    }


def _decaying(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Make a body softer or stiffer at its clamp; a stiff root cannot change all of its sag."""
    sag = tip_sag(setup)
    end = float(random.choice([-3.0, 2.5]))
    contrasts = np.linspace(0.0, end, 101)
    # By the tip's share of an even load's moments, (1 - share)^3, a part is softer by exp(c).
    shares = (np.arange(200) + 0.5) / 200.0
    softer = np.exp(contrasts[:, None] * np.exp(-shares / DECAY)) @ (1.0 - shares) ** 3 / 50.0
    contrast = np.interp(_MOVES[size], sag * np.abs(softer - 1.0), contrasts)
    return {'contrast_mode': 'decaying', 'contrast': number(float(contrast), random)}


def _trailing(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    at = round(float(random.uniform(0.5, 0.75)), 3)
    shape = setup.shape
    place = shape.place(np.array([[shape.clamp + at * (shape.length - shape.clamp), 0.0, 0.0]]))
    high = float(applied(setup.observations[0].world_from_object, place)[0, 1])
    drop = round(float(random.uniform(0.07, 0.1)), 4)
    # The lower a place sinks, the less hangs from it.
    grams = 1.1e3 * _force(size, setup, at) / 9.81
    return {
        'mass_form': 'trailing',
        'added_mass': number(grams, random),
        'added_mass_at': at,
        'mass_drop': drop,
        'mass_table': round(high - drop, 5),
    }


def _thread(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw one place to the side by a thread that runs over a pulley far away to a weight."""
    at = round(float(random.uniform(0.5, 0.75)), 4)
    mass, _ = weight_moment(setup)
    # More than the formula asks: a body is wide, or hangs aslant, in some poses.
    share = 1.5 * _force(size, setup, at) / (9.81 * mass)
    angle = np.rad2deg(np.arcsin(min(share, 0.75)))
    # About the world's x it draws across the body, about z along it.
    across = signed(float(angle), random)
    aslant = across * np.tan(random.uniform(-0.5, 0.5))
    return {
        'tilt_form': 'thread',
        'gravity_tilt': (across, round(float(aslant), 4)),
        'tilt_at': at,
    }


def _roll(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'contact_form': 'roll',
        'contact_height': number((3.0, 5.5, 10.0)[size], random),
        'contact_share': round(float(random.uniform(0.62, 0.8)), 4),
    }


def _force(size: int, setup: Setup, at: float) -> float:
    """Return which force at a place moves the tip as far as a size asks [N]."""
    return _MOVES[size] * tip_stiffness(setup) / (0.5 * at**2 * (3.0 - at))


NINTH_FORMS = (
    Form('camera_offset', 'decentred', _decentred),
    drawn_form(
        'clamp_offset',
        'slid out',
        {},
        'clamp_slid',
        lambda size, random: number((1.5, 4.5, 9.0)[size], random),
    ),
    Form('compliant_clamp', 'flexure', _flexure),
    Form('rest_curvature', 'kink', _kink),
    Form('stiffness_contrast', 'decaying', _decaying),
    Form('added_mass', 'trailing', _trailing),
    drawn_form(
        'depth_affine',
        'walk',
        {'depth_form': 'walk'},
        'depth_bias',
        lambda size, random: signed((1.5, 4.0, 8.0)[size], random),
    ),
    drawn_form(
        'depth_bias_by_region',
        'sprayed',
        {'region_above': True},
        'region_bias',
        lambda size, random: signed((2.0, 5.0, 10.0)[size], random),
    ),
    Form('contact_plane', 'roll', _roll),
    Form('gravity_tilt', 'thread', _thread),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
NINTH_PAIRS = (
    ('camera_offset/decentred', 'gravity_tilt/thread'),
    ('clamp_offset/slid out', 'depth_affine/walk'),
    ('compliant_clamp/flexure', 'rest_curvature/kink'),
    ('contact_plane/roll', 'depth_bias_by_region/sprayed'),
    ('added_mass/trailing', 'stiffness_contrast/decaying'),
    ('rest_curvature/kink', 'camera_offset/drifting'),
    ('gravity_tilt/thread', 'clamp_offset/another each pose'),
    ('strain_stiffening/fung', 'depth_bias_by_region/sprayed'),
)
