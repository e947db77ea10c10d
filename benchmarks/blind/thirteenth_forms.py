# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the thirteenth set alone has, and its pairs.

The second and third size of a form change what is seen of a body by some 5 and 10 mm.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.outside_forms import tip_sag, tip_stiffness
from benchmarks.blind.setups import Setup
from benchmarks.blind.twelfth_forms import held_moment

_MOVES = (0.002, 0.005, 0.010)  # Of the tip [m], by the formulas of a slender beam.
_MOST_BLOWN = (0.2, 0.45, 0.75)  # Of the weight, by which a stream of air presses.


def _recovering(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Take a body off its reel just before, so that it still straightens from pose to pose."""
    free = setup.shape.length - setup.shape.clamp
    power = random.uniform(0.4, 0.8)
    shares = (1.0 + np.arange(len(setup.observations))) ** -power
    return {
        'rest_curvature': direction(2.4 * _MOVES[size] / free**2, 2, random),
        'curvature_shares': tuple(round(float(share), 4) for share in shares),
    }


def _blower(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a blower on beside the bench, whose stream presses what faces it."""
    # More than the formula asks: faces stand aslant to the stream in most poses.
    share = min(1.6 * _MOVES[size] / tip_sag(setup), _MOST_BLOWN[size])
    across = signed(float(np.rad2deg(np.arcsin(share))), random)
    # About the world's x it blows across the body, about z along it.
    aslant = across * np.tan(random.uniform(-0.4, 0.4))
    return {'tilt_form': 'blower', 'gravity_tilt': (across, round(float(aslant), 4))}


def _receding(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Dip the outer part in a solvent, which dries from its upper edge on."""
    begin, end = random.uniform(0.2, 0.35), random.uniform(0.65, 0.8)
    through = np.arange(len(setup.observations)) / max(len(setup.observations) - 1, 1)
    places = begin + (end - begin) * np.sqrt(through)
    return {
        'region_bias': signed((2.0, 5.0, 10.0)[size], random),
        'region_places': tuple(round(float(place), 4) for place in places),
    }


def _pooled(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Tape a closed tube along a body, which a liquid fills in part."""
    inner = round(float(random.uniform(0.2, 0.35)), 4)
    outer = round(float(random.uniform(0.8, 0.92)), 4)
    filled = round(float(random.uniform(0.35, 0.55)), 4)
    # Where the body sags it lies in the outer part.
    places = np.linspace(outer - filled * (outer - inner), outer, 50)
    lever = float((0.5 * places**2 * (3.0 - places)).mean())
    grams = 1e3 * _MOVES[size] * tip_stiffness(setup) / lever / 9.81
    return {
        'mass_form': 'pooled',
        'added_mass': number(grams, random),
        'mass_stops': (inner, outer),
        'mass_filled': filled,
    }


def _streaky(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stir two parts of a rubber too little, so that harder and softer streaks lie aslant."""
    wave = round(float(random.uniform(1.1, 1.5)), 4)
    contrasts = np.linspace(0.0, float(random.choice([-2.0, 3.0])), 101)
    # By the tip's share of an even load's moments, (1 - share)^3, a part is stiffer by exp(c).
    shares = (np.arange(200) + 0.5) / 200.0
    swings = np.sin(2.0 * np.pi * shares / wave)
    sags = np.exp(-contrasts[:, None] * swings) @ (1.0 - shares) ** 3 / 50.0
    changes = np.maximum.accumulate(tip_sag(setup) * np.abs(sags - 1.0))
    return {
        'contrast_mode': 'streaky',
        'contrast': number(float(np.interp(_MOVES[size], changes, contrasts)), random),
        'contrast_wave': wave,
        'contrast_slant': signed(0.06, random),
    }


def _dish(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Leave a round dish below the tip, which touches it beside its middle."""
    beside = direction(0.007, 2, random)
    return {
        'contact_form': 'dish',
        'contact_height': number((1.5, 4.0, 7.0)[size], random),
        'contact_ahead': beside[0],
        'contact_at': beside[1],
        'contact_round': round(float(random.uniform(0.13, 0.2)), 4),
    }


def _rubbing(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Hold a clamp by a sprung hinge that rubs, and stays where it came to in every pose."""
    moment = held_moment(setup)
    rub = round(float(random.uniform(0.3, 0.45)) * moment, 6)
    compliance = float(np.deg2rad((1.0, 2.5, 5.0)[size])) / (moment - rub)
    return {
        'clamp_form': 'rubbing',
        'clamp_compliance': number(compliance, random),
        'clamp_rub': rub,
    }


def _pane(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Stand a shield of acrylic aslant between camera and body."""
    aslant, around = np.deg2rad(random.uniform(35.0, 50.0)), random.uniform(0.0, 2.0 * np.pi)
    across = np.sin(aslant) * np.array([np.cos(around), np.sin(around)])
    normal = (*across, float(np.cos(aslant)))
    return {
        # All is seen nearer by some nine twentieths of its thickness.
        'pane': number((4.5, 11.0, 22.0)[size], random),
        'pane_normal': tuple(round(float(value), 6) for value in normal),
    }


THIRTEENTH_FORMS = (
    Form('rest_curvature', 'recovering', _recovering),
    Form('gravity_tilt', 'blower', _blower),
    Form('depth_bias_by_region', 'receding', _receding),
    Form('added_mass', 'pooled', _pooled),
    Form('stiffness_contrast', 'streaky', _streaky),
    Form('contact_plane', 'dish', _dish),
    Form('compliant_clamp', 'rubbing', _rubbing),
    Form('camera_offset', 'pane', _pane),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
THIRTEENTH_PAIRS = (
    ('rest_curvature/recovering', 'depth_affine/entry'),
    ('gravity_tilt/blower', 'clamp_offset/clamped twice'),
    ('added_mass/pooled', 'camera_offset/pane'),
    ('strain_stiffening/recruited', 'depth_bias_by_region/receding'),
)
