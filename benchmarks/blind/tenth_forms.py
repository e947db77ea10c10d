# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the tenth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 5 and 10 mm.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed, weight_moment
from benchmarks.blind.form import drawn_form, Form
from benchmarks.blind.moduli import lamp_light
from benchmarks.blind.outside_forms import tip_sag
from benchmarks.blind.setups import Setup

_MOVES = (0.002, 0.005, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_PLAY_FROM = 0.15  # Share of the usual moment that takes a clamp through much of its play.
_MOST_ASIDE = 0.6  # Of the weight, by which a turning table draws a body outward.


def _refocused(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Focus anew in every pose, which moves a lens group and with it scale and middle."""
    shares = random.uniform(-1.0, 1.0, len(setup.observations))
    shares /= np.abs(shares).max()
    return {
        'focal_scale': number((0.02, 0.05, 0.1)[size], random),
        'center_shift': direction((2.0, 5.0, 10.0)[size], 2, random),
        'focus_shares': tuple(round(float(share), 4) for share in shares),
    }


def _dragged(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Tighten a jaw that takes the face below it along, so that what is held is sheared."""
    free = setup.shape.length - setup.shape.clamp
    return {'clamp_drag': direction(_MOVES[size] / free, 2, random)}


def _play(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a clamp by a bolt in a wide hole: it gives way easily, and then no more."""
    _, moment = weight_moment(setup)
    play = number((0.9, 2.2, 4.4)[size], random)
    compliance = float(np.deg2rad(play)) / (_PLAY_FROM * moment)
    return {
        'clamp_form': 'play',
        'clamp_play': play,
        'clamp_compliance': round(compliance, 5),
    }


def _trestles(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cure a body in a mould that sagged between two trestles, and a little beyond them."""
    free = setup.shape.length - setup.shape.clamp
    curvature = direction(2.0 * _MOVES[size] / free**2, 2, random)
    return {'curvature_form': 'trestles', 'rest_curvature': curvature}


def _lamp(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Cure, or age, a body more or less below a lamp near its clamp."""
    sag = tip_sag(setup)
    at = round(float(random.uniform(0.08, 0.3)), 4)
    contrasts = np.linspace(0.0, float(random.choice([-2.5, 3.0])), 101)
    # By the tip's share of an even load's moments, (1 - share)^3, a part is stiffer by exp(c).
    shares = (np.arange(200) + 0.5) / 200.0
    sags = np.exp(-contrasts[:, None] * lamp_light(shares, at)) @ (1.0 - shares) ** 3 / 50.0
    contrast = np.interp(_MOVES[size], sag * np.abs(sags - 1.0), contrasts)
    return {
        'contrast_mode': 'lamp',
        'contrast': number(float(contrast), random),
        'contrast_at': at,
    }


def _step(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'contact_form': 'step',
        'contact_height': number((2.0, 4.5, 8.5)[size], random),
        'contact_share': round(float(random.uniform(0.62, 0.8)), 4),
        'contact_step': round(float(random.uniform(2.5, 4.5)), 3),
    }


def _turntable(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Turn rig and camera steadily on a table whose axis stands beside the body."""
    sag = tip_sag(setup)
    share = min(_MOVES[size] / sag, _MOST_ASIDE)
    # About the world's x it draws across the body, about z along it.
    across = signed(float(np.rad2deg(np.arcsin(share))), random)
    aslant = across * np.tan(random.uniform(-0.5, 0.5))
    return {
        'tilt_form': 'turntable',
        'gravity_tilt': (across, round(float(aslant), 4)),
        'tilt_radius': round(float(random.uniform(0.15, 0.3)), 4),
    }


TENTH_FORMS = (
    Form('camera_offset', 'refocused', _refocused),
    Form('clamp_offset', 'dragged', _dragged),
    Form('compliant_clamp', 'play', _play),
    Form('rest_curvature', 'trestles', _trestles),
    Form('stiffness_contrast', 'lamp', _lamp),
    drawn_form(
        'depth_affine',
        'upper rows',
        {'depth_form': 'upper rows'},
        'depth_bias',
        lambda size, random: signed((2.0, 5.0, 10.0)[size], random),
    ),
    Form('contact_plane', 'step', _step),
    Form('gravity_tilt', 'turntable', _turntable),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
TENTH_PAIRS = (
    ('camera_offset/refocused', 'rest_curvature/trestles'),
    ('clamp_offset/dragged', 'added_mass/cable'),
    ('compliant_clamp/play', 'depth_affine/upper rows'),
    ('stiffness_contrast/lamp', 'depth_bias_by_region/sprayed'),
)
