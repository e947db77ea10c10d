# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The library's effects in mathematical forms that are not the library's, and worlds around them.

Every case has a sensor drawn anew, bodies placed up to some tenths of a millimetre and a degree
from where the scene says, and a scene that says of these errors what is true, half or twice as
much. The forms of each set are none of another's.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import direction, number, signed
from benchmarks.blind.eighteenth_forms import EIGHTEENTH_FORMS
from benchmarks.blind.eighth_forms import EIGHTH_FORMS
from benchmarks.blind.eleventh_forms import ELEVENTH_FORMS
from benchmarks.blind.fifteenth_forms import FIFTEENTH_FORMS
from benchmarks.blind.form import (
    border_form,
    camera_form,
    contact_form,
    contrast_form,
    curvature_form,
    depth_form,
    Form,
    give_form,
    mass_form,
    stiffening_form,
    tilt_form,
)
from benchmarks.blind.fourteenth_forms import FOURTEENTH_FORMS
from benchmarks.blind.nineteenth_forms import NINETEENTH_FORMS
from benchmarks.blind.ninth_forms import NINTH_FORMS
from benchmarks.blind.rotations import rigid, rotation
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.seventeenth_forms import SEVENTEENTH_FORMS
from benchmarks.blind.seventh_forms import SEVENTH_FORMS
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.sixteenth_forms import SIXTEENTH_FORMS
from benchmarks.blind.tenth_forms import TENTH_FORMS
from benchmarks.blind.thirteenth_forms import THIRTEENTH_FORMS
from benchmarks.blind.thirtieth_forms import THIRTIETH_FORMS
from benchmarks.blind.thirtyfirst_forms import THIRTYFIRST_FORMS
from benchmarks.blind.thirtysecond_forms import THIRTYSECOND_FORMS
from benchmarks.blind.thirtythird_forms import THIRTYTHIRD_FORMS
from benchmarks.blind.twelfth_forms import TWELFTH_FORMS
from benchmarks.blind.twentieth_forms import TWENTIETH_FORMS
from benchmarks.blind.twentyeighth_forms import TWENTYEIGHTH_FORMS
from benchmarks.blind.twentyfifth_forms import TWENTYFIFTH_FORMS
from benchmarks.blind.twentyfirst_forms import TWENTYFIRST_FORMS
from benchmarks.blind.twentyfourth_forms import TWENTYFOURTH_FORMS
from benchmarks.blind.twentyninth_forms import TWENTYNINTH_FORMS
from benchmarks.blind.twentysecond_forms import TWENTYSECOND_FORMS
from benchmarks.blind.twentyseventh_forms import TWENTYSEVENTH_FORMS
from benchmarks.blind.twentysixth_forms import TWENTYSIXTH_FORMS
from benchmarks.blind.twentythird_forms import TWENTYTHIRD_FORMS

_POSITION_ERROR, _ROTATION_ERROR = 0.0003, 0.2  # One standard deviation [m], [deg].
_MISSTATED = (0.5, 1.0, 2.0)


def _edge(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'contact_form': 'edge',
        # Nearer to the clamp than a tip, it lifts that by more.
        'contact_height': number((2.0, 4.0, 7.0)[size], random),
        'contact_share': round(float(random.uniform(0.62, 0.8)), 4),
    }


def _drifting(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'camera_drifts': True,
        'camera_shift': direction((2.0, 5.0, 12.0)[size], 3, random),
        'camera_turn': direction((0.5, 1.2, 3.0)[size], 3, random),
    }


def _another_each_pose(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    amount = (1.0, 2.5, 6.0)[size]
    return {
        'clamp_shift': direction(amount, 3, random),
        'clamp_turn': direction(amount, 3, random),
        'clamp_scatter': tuple(
            direction(0.3 * amount, 3, random) + direction(0.3 * amount, 3, random)
            for _ in setup.observations
        ),
    }


def _temperature(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
    return {
        'depth_form': 'temperature',
        'depth_bias': signed((1.5, 4.0, 9.0)[size], random),
        'depth_scale': signed((0.4, 1.0, 2.5)[size], random),
    }


FORMS: dict[str, tuple[Form, ...]] = {
    'development': (
        stiffening_form('gent', (16.0, 40.0, 80.0)),
        stiffening_form('cubic', (300.0, 1000.0, 4000.0)),
        contrast_form('smooth'),
        mass_form('ring'),
        mass_form('smear'),
        give_form('uneven'),
        give_form('shear'),
        Form(
            'camera_offset',
            'focal',
            lambda size, setup, random: {'focal_scale': signed((0.004, 0.01, 0.03)[size], random)},
        ),
        tilt_form('side_force'),
        curvature_form('tip'),
        depth_form('radial'),
        border_form('early border', {'region_from': 0.35}),
        Form(
            'clamp_offset',
            'slips on',
            lambda size, setup, random: {
                'clamp_steps': True,
                'clamp_shift': direction((1.0, 2.5, 6.0)[size], 3, random),
            },
        ),
    ),
    'sealed': (
        stiffening_form('mooney_rivlin', (0.3, 0.6, 0.9)),
        stiffening_form('ogden', (0.2, 0.4, 0.7)),
        stiffening_form('fung', (10.0, 30.0, 80.0)),
        contrast_form('thirds'),
        contrast_form('skin'),
        mass_form('point'),
        give_form('jaw'),
        Form(
            'camera_offset',
            'lens',
            lambda size, setup, random: {
                'radial_distortion': signed((0.05, 0.1, 0.3)[size], random),
                'center_shift': direction((4.0, 9.0, 20.0)[size], 2, random),
            },
        ),
        tilt_form('rig_force'),
        curvature_form('twist'),
        depth_form('drift'),
        border_form('late border', {'region_from': 0.65}),
        Form(
            'clamp_offset',
            'turns on',
            lambda size, setup, random: {
                'clamp_steps': True,
                'clamp_turn': direction((1.0, 2.5, 6.0)[size], 3, random),
            },
        ),
        contact_form('foam'),
    ),
    'anew': (
        contrast_form('cosine'),
        mass_form('two'),
        give_form('hardening'),
        camera_form('aspect', 'aspect', (0.003, 0.008, 0.02)),
        tilt_form('growing'),
        depth_form('disparity'),
        Form(
            'clamp_offset',
            'slips once',
            lambda size, setup, random: {
                'clamp_late': True,
                'clamp_shift': direction((1.0, 2.5, 6.0)[size], 3, random),
                'clamp_turn': direction((0.5, 1.2, 3.0)[size], 3, random),
            },
        ),
    ),
    'fifth': (
        contrast_form('late'),
        contrast_form('square'),
        mass_form('coat'),
        give_form('softening'),
        tilt_form('outer_push'),
        curvature_form('root'),
        depth_form('ramp'),
        depth_form('settling'),
        border_form('near the tip', {'region_from': 0.78}),
        camera_form('focal and centre', 'focal_scale', (0.003, 0.008, 0.02)),
        contact_form('shelf'),
    ),
    'sixth': (
        Form('contact_plane', 'edge', _edge),
        contact_form('friction'),
        border_form('gradual', {'region_ramp': 0.15}),
        Form('camera_offset', 'drifting', _drifting),
        curvature_form('S'),
        curvature_form('middle'),
        Form('clamp_offset', 'another each pose', _another_each_pose),
        mass_form('opposite'),
        give_form('about a corner'),
        contrast_form('spot'),
        tilt_form('changing'),
        Form('depth_affine', 'temperature', _temperature),
    ),
    'seventh': SEVENTH_FORMS,
    'eighth': EIGHTH_FORMS,
    'ninth': NINTH_FORMS,
    'tenth': TENTH_FORMS,
    'eleventh': ELEVENTH_FORMS,
    'twelfth': TWELFTH_FORMS,
    'thirteenth': THIRTEENTH_FORMS,
    'fourteenth': FOURTEENTH_FORMS,
    'fifteenth': FIFTEENTH_FORMS,
    'sixteenth': SIXTEENTH_FORMS,
    'seventeenth': SEVENTEENTH_FORMS,
    'eighteenth': EIGHTEENTH_FORMS,
    'nineteenth': NINETEENTH_FORMS,
    'twentieth': TWENTIETH_FORMS,
    'twentyfirst': TWENTYFIRST_FORMS,
    'twentysecond': TWENTYSECOND_FORMS,
    'twentythird': TWENTYTHIRD_FORMS,
    'twentyfourth': TWENTYFOURTH_FORMS,
    'twentyfifth': TWENTYFIFTH_FORMS,
    'twentysixth': TWENTYSIXTH_FORMS,
    'twentyseventh': TWENTYSEVENTH_FORMS,
    'twentyeighth': TWENTYEIGHTH_FORMS,
    'twentyninth': TWENTYNINTH_FORMS,
    'thirtieth': THIRTIETH_FORMS,
    'thirtyfirst': THIRTYFIRST_FORMS,
    'thirtysecond': THIRTYSECOND_FORMS,
    'thirtythird': THIRTYTHIRD_FORMS,
}
# Of the sixth set, two at a time, of different effects: some of its own, some that sets of before
# had singly.
PAIRS = (
    ('added_mass/coat', 'rest_curvature/root'),
    ('depth_affine/temperature', 'clamp_offset/another each pose'),
    ('camera_offset/drifting', 'stiffness_contrast/late'),
    ('contact_plane/edge', 'depth_bias_by_region/near the tip'),
    ('strain_stiffening/fung', 'depth_affine/ramp'),
    ('gravity_tilt/changing', 'depth_bias_by_region/gradual'),
    ('compliant_clamp/about a corner', 'depth_affine/disparity'),
    ('rest_curvature/S', 'camera_offset/focal and centre'),
    ('stiffness_contrast/spot', 'clamp_offset/slips once'),
    ('added_mass/opposite', 'camera_offset/aspect'),
    ('contact_plane/shelf', 'clamp_offset/turns on'),
    ('gravity_tilt/outer_push', 'strain_stiffening/gent'),
)
BY_KEY = {form.key: form for forms in FORMS.values() for form in forms}


def off_the_truth(setup: Setup, sensor: str, random: np.random.Generator) -> Setup:
    """Return a set-up with a drawn sensor, and placements that the scene states a little wrong.

    Args:
        setup: as it is drawn where all is known.
        sensor: one of `sensor.DRAWN`.
        random: source.
    """
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    factor = float(random.choice(_MISSTATED))
    middle = np.array([0.5 * setup.shape.length, 0.0, 0.0])
    seen = [
        replace(observation, stated=observation.world_from_object @ _small_motion(middle, random))
        for observation in setup.observations
    ]
    return replace(
        setup,
        sensor=DRAWN[sensor](random, distance),
        observations=tuple(seen),
        pose_errors=(factor * _POSITION_ERROR, factor * _ROTATION_ERROR),
    )


def placed_again(setup: Setup, before: Setup) -> Setup:
    """Return a set-up whose scene is as far off as before, where bodies were placed again."""
    seen = [
        Observation(
            new.name,
            new.world_from_object,
            new.world_from_object @ np.linalg.inv(old.world_from_object) @ old.stated,
        )
        if old.stated is not None
        else new
        for new, old in zip(setup.observations, before.observations, strict=True)
    ]
    return replace(setup, observations=tuple(seen))


def _small_motion(middle: FloatArray, random: np.random.Generator) -> FloatArray:
    turn = rotation(np.deg2rad(_ROTATION_ERROR * random.standard_normal(3)))
    shift = _POSITION_ERROR * random.standard_normal(3)
    return rigid(turn, middle - turn @ middle + shift)
