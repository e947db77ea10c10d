# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the library's effects that the seventh set alone has, and its pairs."""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.form import (
    contrast_form,
    curvature_form,
    Form,
    give_form,
    mass_form,
)
from benchmarks.blind.setups import Setup


def _knocked(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        # Between the first and the second pose, or between the second and the third.
        'camera_from': min(int(random.integers(1, 3)), len(setup.observations) - 1),
        'camera_shift': direction((2.0, 5.0, 12.0)[size], 3, random),
        'camera_turn': direction((0.5, 1.2, 3.0)[size], 3, random),
    }


def _slips_by_load(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    amount = (1.5, 3.5, 8.0)[size]
    return {
        'clamp_by_load': True,
        'clamp_shift': direction(amount, 3, random),
        'clamp_turn': direction(0.5 * amount, 3, random),
    }


def _one_sided(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    one, other = (float(random.choice([-1.0, 1.0])) for _ in range(2))
    return {
        **give_form('one-sided').draw(size, setup, random),
        'clamp_way': (one, other),
    }


def _on_an_arm(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        **mass_form('arm').draw(size, setup, random),
        'mass_arm': direction((16.0, 20.0, 24.0)[size], 2, random),
    }


def _oblique(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'region_slant': signed(0.2, random),
        'region_bias': signed((0.8, 2.0, 5.0)[size], random),
    }


def _on_the_rig(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    tilt = np.deg2rad(random.uniform(-6.0, 6.0, size=2))
    normal = np.array([np.sin(tilt[0]), np.sin(tilt[1]), 1.0])
    normal /= np.linalg.norm(normal)
    return {
        'contact_form': 'rig',
        'contact_height': number((2.0, 5.0, 11.0)[size], random),
        'contact_normal': tuple(round(float(value), 6) for value in normal),
    }


def _incidence(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {'depth_form': 'incidence', 'depth_bias': signed((1.0, 2.5, 6.0)[size], random)}


def _middle_push(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'tilt_form': 'middle_push',
        'gravity_tilt': direction((5.0, 12.0, 25.0)[size], 2, random),
    }


SEVENTH_FORMS = (
    Form('camera_offset', 'knocked', _knocked),
    Form('clamp_offset', 'slips by load', _slips_by_load),
    Form('compliant_clamp', 'one-sided', _one_sided),
    curvature_form('helix'),
    contrast_form('three pours'),
    Form('added_mass', 'arm', _on_an_arm),
    Form('depth_affine', 'incidence', _incidence),
    Form('depth_bias_by_region', 'oblique border', _oblique),
    Form('contact_plane', 'rig', _on_the_rig),
    Form('gravity_tilt', 'middle_push', _middle_push),
)
# Two at a time, of different effects: new ones, and some that sets of before had singly.
SEVENTH_PAIRS = (
    ('camera_offset/knocked', 'compliant_clamp/one-sided'),
    ('added_mass/arm', 'depth_affine/incidence'),
    ('rest_curvature/helix', 'stiffness_contrast/cosine'),
    ('clamp_offset/slips by load', 'depth_bias_by_region/gradual'),
    ('contact_plane/rig', 'added_mass/coat'),
    ('gravity_tilt/middle_push', 'rest_curvature/tip'),
    ('stiffness_contrast/three pours', 'strain_stiffening/gent'),
    ('depth_bias_by_region/oblique border', 'clamp_offset/another each pose'),
)
