# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the thirty-fifth set is drawn from: rigs, and effects as earlier sets have them."""

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import number, signed
from benchmarks.blind.further_bodies import FURTHER_FAMILIES
from benchmarks.blind.other_ranges import Ranges
from benchmarks.blind.other_rigs import OtherSetup
from benchmarks.blind.setups import GRAVITY
from benchmarks.blind.thirtyfourth_forms import BY_KEY_34, free_mass, OtherForm

RANGES_35 = Ranges(
    families=FURTHER_FAMILIES,
    images={
        (320, 240): (0.8, 1.0),
        (512, 424): (0.7, 0.9),
        (640, 400): (0.6, 0.75),
        (960, 540): (0.65, 0.8),
    },
    filled=(0.35, 0.9),
    distances=(0.15, 0.8),
    smooth=(0.00012, 0.0006),
    misstated=(1.0, 1.0, 1.0, 1.0, 1.5, 1.0 / 1.5),
    moduli=(30.0e3, 5.0e6),
    frames=(3, 8),
)
# Of what is seen, of a single effect and of each of a pair [m].
LEAST_CHANGES_35 = (0.002, 0.003)
_CHANGES = {1: (0.0032, 0.006), 2: (0.006, 0.012)}  # By size [m].
_MOST_SHARE = 0.12  # Of the free length, unless that is less than all changes are.

_LOW_TIP = ('ribbon', 'tentacle', 'bellows', 'fork', 'wedge', 'twisted')
_STRAIGHT = ('ring', 'bellows', 'fork', 'wedge', 'twisted')
_THICK = ('horseshoe', 'tentacle', 'bellows', 'fork', 'wedge', 'crescent')


def wanted_change_35(setup: OtherSetup, size: int, random: np.random.Generator) -> float:
    """Draw by how much an effect of a size is to change what is seen at most [m]."""
    drawn = float(np.exp(random.uniform(*np.log(_CHANGES[size]))))
    return max(min(drawn, _MOST_SHARE * setup.body.free), _CHANGES[1][0])


def _library(truth: str, families: tuple[str, ...] = ()) -> OtherForm:
    return replace(BY_KEY_34[f'{truth}/library'], families=families)


def _also(name: str, form: OtherForm, poses: int = 2, **more: Any) -> OtherForm:
    """Return another form, which has more faults or others."""

    def draw(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
        return {**form.draw(setup, random), **more}

    return replace(form, name=name, draw=draw, poses=poses)


def _slanted(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    return {'region_bias': signed(1.0, random), 'region_slant': signed(0.2, random)}


def _shear(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    give = number(0.003 / (free_mass(setup) * GRAVITY), random)
    return {'clamp_form': 'shear', 'clamp_compliance': give}


def _shares(setup: OtherSetup, random: np.random.Generator) -> tuple[float, ...]:
    """Draw how much of something is there in each pose."""
    return tuple(round(float(random.uniform(0.3, 1.0)), 4) for _ in setup.observations)


def _heat(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    growth = 2.0 * setup.body.section[1] / setup.body.free
    return {'heat': signed(growth, random), 'heat_shares': _shares(setup, random)}


def _jet(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    side = float(random.choice([-1.0, 1.0]))
    return {
        'jet': number(0.1 * free_mass(setup) * GRAVITY, random),
        'jet_at': round(float(random.uniform(0.5, 0.75)), 4),
        'jet_normal': (0.0, 0.0, side),
        'jet_shares': _shares(setup, random),
    }


def _wiggle(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'wiggle': number(1.0, random),
        'wiggle_period': round(float(random.uniform(40.0, 90.0)), 3),
        'wiggle_phase': round(float(random.uniform(0.0, 2.0 * np.pi)), 4),
    }


_CONTRAST = BY_KEY_34['stiffness_contrast/split']
FORMS_35 = (
    _library('camera_offset'),
    _also('sags', _library('camera_offset'), poses=3, camera_sags=True),
    _library('depth_affine'),
    OtherForm(
        'depth_affine',
        'temperature',
        ('depth_scale',),
        lambda setup, random: {'depth_form': 'temperature', 'depth_scale': signed(1.0, random)},
        seen_by='depth',
        poses=3,
    ),
    _also('early border', _library('depth_bias_by_region'), region_from=0.35),
    replace(BY_KEY_34['depth_bias_by_region/library'], name='slanted', draw=_slanted),
    _library('gravity_tilt'),
    _also('side force', _library('gravity_tilt'), tilt_form='side_force'),
    _also('ring', _library('added_mass'), mass_form='ring'),
    _also('two', _library('added_mass'), mass_form='two'),
    _library('clamp_offset'),
    _also('late', _library('clamp_offset'), clamp_late=True),
    _library('compliant_clamp'),
    OtherForm('compliant_clamp', 'shear', ('clamp_compliance',), _shear),
    _library('rest_curvature'),
    _also('S', _library('rest_curvature', _STRAIGHT), curvature_form='S'),
    _also('smooth', _CONTRAST, contrast_mode='smooth'),
    _also('late', _CONTRAST, contrast_mode='late'),
    OtherForm(
        'strain_stiffening',
        'recruited',
        ('stiffening',),
        lambda setup, random: {
            'stiffening_form': 'recruited',
            'stiffening_from': round(float(random.uniform(0.02, 0.05)), 4),
            'stiffening': number(2.0, random),
        },
        most=3.0,
        families=_THICK,
        sags=True,
    ),
    _library('contact_plane', _LOW_TIP),
)
OUTSIDE_35 = (
    OtherForm('heat', 'outside', ('heat',), _heat),
    OtherForm('jet', 'outside', ('jet',), _jet),
    OtherForm(
        'memory',
        'outside',
        ('memory',),
        lambda setup, random: {'memory': number(0.15, random)},
        most=5.0,
        sags=True,
        poses=3,
    ),
    OtherForm('wiggle', 'outside', ('wiggle',), _wiggle, seen_by='depth'),
)
PAIRS_35 = (
    ('added_mass/ring', 'depth_affine/library'),
    ('gravity_tilt/library', 'clamp_offset/library'),
    ('compliant_clamp/library', 'camera_offset/library'),
    ('rest_curvature/library', 'depth_bias_by_region/early border'),
    ('stiffness_contrast/smooth', 'camera_offset/sags'),
    ('contact_plane/library', 'depth_affine/temperature'),
)
