# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the thirty-sixth set is drawn from: rigs, single effects, and many pairs of two."""

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.later_bodies import LATER_FAMILIES
from benchmarks.blind.other_ranges import Ranges
from benchmarks.blind.other_rigs import OtherSetup
from benchmarks.blind.thirtyfifth_forms import FORMS_35
from benchmarks.blind.thirtyfourth_forms import BY_KEY_34, Draw, OtherForm

RANGES_36 = Ranges(
    families=LATER_FAMILIES,
    images={
        (480, 360): (0.7, 0.9),
        (640, 576): (0.75, 0.95),
        (672, 376): (0.55, 0.75),
        (1024, 576): (0.6, 0.8),
    },
    filled=(0.4, 0.9),
    distances=(0.18, 0.9),
    smooth=(0.00012, 0.0007),
    misstated=(1.0, 1.0, 1.0, 1.0, 1.7, 1.0 / 1.7),
    moduli=(20.0e3, 8.0e6),
    frames=(3, 8),
)

_EARLIER = {**BY_KEY_34, **{form.key: form for form in FORMS_35}}
_ONE_CLAMP = tuple(name for name in LATER_FAMILIES if name != 'vault')
_AHEAD = ('zigzag', 'comb', 'wye', 'crank')  # Of which no part comes back along x.
_LOW_TIP = ('zigzag', 'comb', 'wye', 'elbow', 'ribbon', 'crank')
_SOLID = ('cane', 'elbow', 'horseshoe')  # That may sag by three tenths.


def _earlier(key: str, families: tuple[str, ...] = ()) -> OtherForm:
    """Return a form of a set before, on bodies of this one; no families: on all."""
    return replace(_EARLIER[key], families=families)


def _other(key: str, name: str, draw: Draw, **more: Any) -> OtherForm:
    """Return what is drawn beside, or in place of, the faults of a form, as another one."""
    form = _earlier(key)

    def drawn(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
        return {**form.draw(setup, random), **draw(setup, random)}

    return replace(form, name=name, draw=drawn, **more)


def _from_amid(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    """Draw the pose from which on a camera stands elsewhere: neither the first nor after all."""
    return {'camera_from': int(random.integers(1, len(setup.observations)))}


def _of_depth(form: str) -> OtherForm:
    return OtherForm(
        'depth_affine',
        form,
        ('depth_bias',),
        lambda setup, random: {'depth_form': form, 'depth_bias': signed(1.0, random)},
        seen_by='depth',
    )


def _slanted(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    slant = signed(random.uniform(0.15, 0.35), random)
    return {'region_from': round(float(random.uniform(0.4, 0.65)), 4), 'region_slant': slant}


def _belt(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    begin, wide = random.uniform((0.25, 0.3), (0.45, 0.4))
    return {'region_from': round(float(begin), 4), 'region_until': round(float(begin + wide), 4)}


def _slides_on(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    return {'clamp_steps': True, 'clamp_shift': direction(1.0, 3, random)}


def _fung(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    return {'stiffening_form': 'fung', 'stiffening': number(20.0, random)}


def _taut(form: str) -> OtherForm:
    """Return a stiffening by what comes taut, which is large enough to be one of a pair."""

    def draw(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
        return {
            'stiffening_form': form,
            'stiffening_from': round(float(random.uniform(0.008, 0.016)), 4),
            'stiffening': number(2.0, random),
        }

    return OtherForm(
        'strain_stiffening',
        form,
        ('stiffening',),
        draw,
        most=8.0,
        families=_SOLID,
        sags=True,
    )


def _shrinking(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    """Draw how much a body shrank by each pose, all of it by the last."""
    shares = np.sort(random.uniform(0.0, 0.9, len(setup.observations) - 1))
    told = (*(round(float(share), 4) for share in shares), 1.0)
    return {'shrinking': number(1.0, random), 'shrinking_shares': told}


def _tiles(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'tiles': number(1.0, random),
        'tiles_edge': int(setup.camera.width * random.uniform(0.05, 0.09)),
        'tiles_seed': int(random.integers(1, 2**31)),
    }


_REGION, _MASS = 'depth_bias_by_region/library', 'added_mass/library'
_SLANTED = _other(_REGION, 'slanted', _slanted)
_DISPARITY = _of_depth('disparity')
FORMS_36 = (
    _other('camera_offset/library', 'from amid', _from_amid, poses=3),
    _DISPARITY,
    _of_depth('near field'),
    _SLANTED,
    _other(_REGION, 'belt', _belt),
    _other('gravity_tilt/library', 'outer push', lambda *_: {'tilt_form': 'outer_push'}),
    _other(
        _MASS,
        'smear',
        lambda setup, random: {
            'mass_form': 'smear',
            'added_mass_at': round(float(random.uniform(0.5, 0.9)), 3),
        },
    ),
    _earlier('contact_plane/foam', _LOW_TIP),
    OtherForm('clamp_offset', 'slides on', ('clamp_shift',), _slides_on, poses=3),
    _earlier('compliant_clamp/shear', _ONE_CLAMP),
    _other(
        'rest_curvature/library',
        'middle',
        lambda *_: {'curvature_form': 'middle'},
        families=_AHEAD,
    ),
    _earlier('rest_curvature/library', _ONE_CLAMP),
    _other('stiffness_contrast/split', 'three pours', lambda *_: {'contrast_mode': 'three pours'}),
    OtherForm(
        'strain_stiffening',
        'fung',
        ('stiffening',),
        _fung,
        most=20.0,
        families=_SOLID,
        sags=True,
    ),
)
# What pairs alone have.
PAIRED_36 = (
    _earlier('camera_offset/library'),
    _earlier('camera_offset/drifting'),
    _earlier('depth_affine/library'),
    _earlier(_REGION),
    _earlier('gravity_tilt/library'),
    _earlier('gravity_tilt/side force'),
    _earlier(_MASS),
    _earlier('added_mass/two'),
    _earlier('added_mass/coat'),
    _earlier('contact_plane/library', _LOW_TIP),
    _earlier('clamp_offset/library'),
    _earlier('compliant_clamp/library', _ONE_CLAMP),
    _other(
        'compliant_clamp/library',
        'about a corner',
        lambda *_: {'clamp_form': 'about a corner'},
        families=_ONE_CLAMP,
    ),
    _earlier('stiffness_contrast/split'),
    _earlier('stiffness_contrast/linear'),
    _taut('recruited'),
    _taut('threaded'),
)
OUTSIDE_36 = (
    OtherForm('shrinking', 'outside', ('shrinking',), _shrinking, most=8.0, poses=3),
    OtherForm('tiles', 'outside', ('tiles',), _tiles, seen_by='depth'),
)
# A contact comes last: a body is laid down as it hangs with what else there is.
PAIRS_36 = (
    ('camera_offset/library', 'depth_bias_by_region/slanted'),
    ('camera_offset/drifting', 'gravity_tilt/library'),
    ('strain_stiffening/recruited', 'camera_offset/library'),
    ('depth_affine/library', 'compliant_clamp/about a corner'),
    ('depth_affine/disparity', 'stiffness_contrast/split'),
    (_REGION, 'added_mass/two'),
    (_MASS, 'compliant_clamp/library'),
    ('strain_stiffening/threaded', 'added_mass/coat'),
    ('gravity_tilt/side force', 'stiffness_contrast/linear'),
    ('clamp_offset/library', 'rest_curvature/library'),
    ('rest_curvature/library', 'contact_plane/library'),
    ('clamp_offset/library', 'contact_plane/library'),
)
