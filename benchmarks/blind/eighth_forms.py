# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the eighth set alone has, and its pairs."""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, weight_moment
from benchmarks.blind.form import (
    border_form,
    contact_form,
    curvature_form,
    drawn_form,
    Form,
    mass_form,
    stiffening_form,
)
from benchmarks.blind.setups import Setup


def _sagging(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Nod about the foot of a mount below the camera and a little to the side, by its weight."""
    nod = number((0.3, 0.8, 1.9)[size], random)
    aside = direction(0.25 * nod, 2, random)
    foot = (random.uniform(-0.03, 0.03), random.uniform(0.1, 0.2), random.uniform(-0.05, 0.0))
    return {
        'camera_sags': True,
        'camera_turn': (-nod, *aside),
        'camera_foot': tuple(round(float(value), 4) for value in foot),
    }


def _clamped_twice(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Put the body into its clamp one way, and another way from some pose on."""
    amount = (1.0, 2.5, 6.0)[size]
    one, other = (direction(amount, 3, random) + direction(amount, 3, random) for _ in range(2))
    change = tuple(round(new - old, 4) for new, old in zip(other, one, strict=True))
    count = len(setup.observations)
    again = min(int(random.integers(1, 4)), count - 1)
    return {
        'clamp_shift': one[:3],
        'clamp_turn': one[3:],
        'clamp_scatter': tuple(change if pose >= again else (0.0,) * 6 for pose in range(count)),
    }


def _lined(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    _, moment = weight_moment(setup)
    # A soft body gives way in foam by several times what a rigid one would.
    compliance = float(np.deg2rad((0.2, 0.5, 1.2)[size])) / moment
    return {'clamp_form': 'lined', 'clamp_compliance': number(compliance, random)}


def _sleeve(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    """Draw a sleeve that is stiffer than the body, as the relief of a strain at a clamp is."""
    return {'contrast_mode': 'sleeve', 'contrast': -number((0.4, 0.9, 1.8)[size], random)}


EIGHTH_FORMS = (
    Form('camera_offset', 'sagging', _sagging),
    Form('clamp_offset', 'clamped twice', _clamped_twice),
    Form('compliant_clamp', 'lined', _lined),
    curvature_form('set'),
    Form('stiffness_contrast', 'sleeve', _sleeve),
    stiffening_form('veronda_westmann', (5.0, 15.0, 40.0)),
    mass_form('cable'),
    drawn_form(
        'depth_affine',
        'near field',
        {'depth_form': 'near field'},
        'depth_bias',
        lambda size, random: number((1.0, 2.5, 6.0)[size], random),
    ),
    border_form('sticker', {'region_from': 0.45, 'region_until': 0.85, 'region_ramp': 0.08}),
    contact_form('mat'),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
EIGHTH_PAIRS = (
    ('camera_offset/sagging', 'strain_stiffening/veronda_westmann'),
    ('clamp_offset/clamped twice', 'added_mass/cable'),
    ('compliant_clamp/lined', 'depth_affine/ramp'),
    ('rest_curvature/set', 'depth_affine/near field'),
    ('stiffness_contrast/sleeve', 'gravity_tilt/side_force'),
    ('contact_plane/mat', 'camera_offset/knocked'),
    ('depth_bias_by_region/sticker', 'rest_curvature/root'),
    ('added_mass/opposite', 'compliant_clamp/lined'),
)
