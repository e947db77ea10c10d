# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects of the thirty-fourth set, as earlier sets have them, on bodies of other kinds.

No formula of a slender bar tells how large they are to be: they are drawn of some size, and then
made larger or smaller until what is seen changes by as much as wanted.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.other_rigs import OtherSetup
from benchmarks.blind.setups import GRAVITY

Draw = Callable[[OtherSetup, np.random.Generator], dict[str, Any]]


@dataclass(frozen=True)
class OtherForm:
    """One form of an effect.

    Attributes:
        truth: identifier of the effect, of the library or outside it.
        name: of the form; `library` for the library's own.
        scaled: names of the faults that are made larger or smaller.
        draw: faults of some size.
        seen_by: `body` where it moves that, else `camera` or `depth`.
        most: factor by which it may be larger than drawn.
        families: of bodies that it makes sense on; empty: all.
        sags: whether it shows on a body that sags much.
        poses: least number of poses in which it shows.
    """

    truth: str
    name: str
    scaled: tuple[str, ...]
    draw: Draw
    seen_by: str = 'body'
    most: float = 30.0
    families: tuple[str, ...] = ()
    sags: bool = False
    poses: int = 2

    @property
    def key(self) -> str:
        """What a list of cases calls it."""
        return self.truth if self.name == 'outside' else f'{self.truth}/{self.name}'


# Bodies with one clamp and something that is a tip.
_TIPPED = ('tube', 'slotted', 'window', 'hand', 'elbow', 'whip', 'sheet', 'stub')
_ONE_CLAMP = (*_TIPPED, 'wings')
_LOW_TIP = ('tube', 'slotted', 'elbow', 'hand', 'whip')
_THICK = ('stub', 'tube', 'slotted', 'elbow', 'wings')


def free_mass(setup: OtherSetup) -> float:
    """Return about how much of a body is not held [kg]: a bar's of half the section all round."""
    width, height = setup.body.section
    return setup.density * setup.body.free * 0.5 * width * height


def turn_of(setup: OtherSetup) -> float:
    """Return the turn that moves a free end by a millimetre [deg]."""
    return float(np.rad2deg(0.001 / setup.body.free))


def _camera(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'camera_shift': direction(1.0, 3, random),
        'camera_turn': direction(turn_of(setup), 3, random),
    }


def _drifting(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    return {**_camera(setup, random), 'camera_drifts': True}


def _depth(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    distance = float(setup.depth_from_world[2, 3])
    return {
        'depth_bias': signed(1.0, random),
        'depth_scale': signed(random.uniform(0.3, 0.6) * 0.1 / distance, random),
    }


def _mass(at: tuple[float, float], **more: Any) -> Draw:
    return lambda setup, random: {
        'added_mass': number(100.0 * free_mass(setup), random),
        'added_mass_at': round(float(random.uniform(*at)), 3),
        **more,
    }


def _give(**more: Any) -> Draw:
    def draw(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
        moment = 0.5 * free_mass(setup) * GRAVITY * setup.body.free
        return {'clamp_compliance': number(0.03 / moment, random), **more}

    return draw


def _offset(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'clamp_shift': direction(1.0, 3, random),
        'clamp_turn': direction(turn_of(setup), 3, random),
    }


def _curved(**more: Any) -> Draw:
    # The tip of an arc is off by half of its curvature times the square of its length.
    return lambda setup, random: {
        'rest_curvature': direction(0.06 / setup.body.free, 2, random),
        **more,
    }


def _tilt(**more: Any) -> Draw:
    return lambda setup, random: {'gravity_tilt': direction(5.0, 2, random), **more}


def _contact(setup: OtherSetup, random: np.random.Generator) -> dict[str, Any]:
    """Draw how a plane lies below a body; by how much it lifts that is told later."""
    slant = np.deg2rad(random.uniform(-6.0, 6.0, size=2))
    normal = np.array([np.sin(slant[0]), 1.0, np.sin(slant[1])])
    normal /= np.linalg.norm(normal)
    return {'contact_height': 1.0, 'contact_normal': tuple(float(value) for value in normal)}


def _contrast(mode: str) -> Draw:
    return lambda setup, random: {'contrast': signed(0.5, random), 'contrast_mode': mode}


FORMS_34 = (
    OtherForm(
        'camera_offset', 'library', ('camera_shift', 'camera_turn'), _camera, seen_by='camera'
    ),
    OtherForm(
        'camera_offset',
        'drifting',
        ('camera_shift', 'camera_turn'),
        _drifting,
        seen_by='camera',
        poses=3,
    ),
    OtherForm('depth_affine', 'library', ('depth_bias', 'depth_scale'), _depth, seen_by='depth'),
    OtherForm(
        'depth_affine',
        'drift',
        ('depth_bias',),
        lambda setup, random: {'depth_form': 'drift', 'depth_bias': signed(1.0, random)},
        seen_by='depth',
        poses=3,
    ),
    OtherForm(
        'depth_bias_by_region',
        'library',
        ('region_bias',),
        lambda setup, random: {'region_bias': signed(1.0, random)},
        seen_by='depth',
    ),
    OtherForm(
        'depth_bias_by_region',
        'gradual',
        ('region_bias',),
        lambda setup, random: {'region_ramp': 0.15, 'region_bias': signed(1.0, random)},
        seen_by='depth',
    ),
    OtherForm('gravity_tilt', 'library', ('gravity_tilt',), _tilt(), most=7.0, sags=True),
    OtherForm(
        'gravity_tilt',
        'growing',
        ('gravity_tilt',),
        _tilt(tilt_form='growing'),
        most=7.0,
        sags=True,
    ),
    OtherForm('added_mass', 'library', ('added_mass',), _mass((0.45, 0.93)), sags=True),
    OtherForm('added_mass', 'coat', ('added_mass',), _mass((0.4, 0.7), mass_form='coat')),
    OtherForm('contact_plane', 'library', (), _contact, families=_LOW_TIP),
    OtherForm(
        'contact_plane',
        'foam',
        (),
        lambda setup, random: {'contact_form': 'foam', **_contact(setup, random)},
        families=_LOW_TIP,
    ),
    OtherForm('clamp_offset', 'library', ('clamp_shift', 'clamp_turn'), _offset),
    OtherForm(
        'clamp_offset',
        'turns on',
        ('clamp_turn',),
        lambda setup, random: {
            'clamp_steps': True,
            'clamp_turn': direction(turn_of(setup), 3, random),
        },
        families=_ONE_CLAMP,
        poses=3,
    ),
    OtherForm('compliant_clamp', 'library', ('clamp_compliance',), _give(), families=_ONE_CLAMP),
    OtherForm(
        'compliant_clamp',
        'uneven',
        ('clamp_compliance',),
        _give(clamp_form='uneven'),
        families=_ONE_CLAMP,
    ),
    OtherForm('rest_curvature', 'library', ('rest_curvature',), _curved()),
    OtherForm(
        'rest_curvature',
        'tip',
        ('rest_curvature',),
        _curved(curvature_form='tip'),
        families=tuple(name for name in _ONE_CLAMP if name != 'elbow'),
    ),
    OtherForm(
        'stiffness_contrast', 'split', ('contrast',), _contrast('split'), most=6.0, sags=True
    ),
    OtherForm(
        'stiffness_contrast', 'linear', ('contrast',), _contrast('linear'), most=6.0, sags=True
    ),
    OtherForm(
        'strain_stiffening',
        'library',
        ('yeoh_ratio',),
        lambda setup, random: {'yeoh_ratio': number(25.0, random)},
        most=20.0,
        families=_THICK,
        sags=True,
    ),
    OtherForm(
        'strain_stiffening',
        'gent',
        ('stiffening',),
        lambda setup, random: {'stiffening_form': 'gent', 'stiffening': number(40.0, random)},
        most=10.0,
        families=_THICK,
        sags=True,
    ),
)
OUTSIDE_34 = (
    OtherForm(
        'side_wind',
        'outside',
        ('wind',),
        lambda setup, random: {'wind': signed(0.2, random)},
        most=5.0,
        sags=True,
    ),
    OtherForm(
        'swelling',
        'outside',
        ('swelling',),
        lambda setup, random: {'swelling': number(2.0, random)},
        most=8.0,
    ),
    OtherForm(
        'warming',
        'outside',
        ('warming',),
        lambda setup, random: {'warming': number(0.3, random)},
        most=5.0,
        sags=True,
        poses=3,
    ),
    OtherForm(
        'stripes',
        'outside',
        ('stripes',),
        lambda setup, random: {
            'stripes': number(1.0, random),
            'stripes_period': round(float(random.uniform(40.0, 90.0)), 3),
            'stripes_phase': round(float(random.uniform(0.0, 2.0 * np.pi)), 4),
        },
        seen_by='depth',
    ),
)
PAIRS_34 = (
    ('added_mass/library', 'camera_offset/library'),
    ('rest_curvature/library', 'depth_affine/drift'),
    ('gravity_tilt/library', 'compliant_clamp/library'),
    ('stiffness_contrast/linear', 'clamp_offset/library'),
)
BY_KEY_34 = {form.key: form for form in (*FORMS_34, *OUTSIDE_34)}
