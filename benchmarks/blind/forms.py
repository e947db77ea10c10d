# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The library's effects in mathematical forms that are not the library's, and worlds around them.

Every case has a sensor drawn anew, bodies placed up to some tenths of a millimetre and a degree
from where the scene says, and a scene that says of these errors what is true, half or twice as
much. The forms of each set are none of another's.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import (
    direction,
    Effect,
    number,
    signed,
    weight_moment,
)
from benchmarks.blind.rotations import rigid, rotation
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray

_POSITION_ERROR, _ROTATION_ERROR = 0.0003, 0.2  # One standard deviation [m], [deg].
_MISSTATED = (0.5, 1.0, 2.0)

Drawer = Callable[[int, Setup, np.random.Generator], Effect]


@dataclass(frozen=True)
class Form:
    """One mathematical form of an effect.

    Attributes:
        truth: identifier of the effect, of the library.
        name: of the form.
        draw: changes of the faults by size, set-up and source of random numbers.
    """

    truth: str
    name: str
    draw: Callable[[int, Setup, np.random.Generator], dict[str, Any]]

    @property
    def key(self) -> str:
        """What a list of cases calls it."""
        return f'{self.truth}/{self.name}'

    def effect(self, size: int, setup: Setup, random: np.random.Generator) -> Effect:
        """Draw the effect."""
        changes = self.draw(size, setup, random)
        told = {name: str(value) for name, value in changes.items()}
        return Effect(self.truth, {'form': self.name, **told}, 'as the faults', changes)


def _drawn(
    truth: str,
    name: str,
    fixed: dict[str, Any],
    key: str,
    draw: Callable[[int, np.random.Generator], Any],
) -> Form:
    """Return a form of which one number or vector is drawn, by size."""
    return Form(truth, name, lambda size, setup, random: {**fixed, key: draw(size, random)})


def _stiffening(form: str, amounts: tuple[float, float, float]) -> Form:
    return _drawn(
        'strain_stiffening',
        form,
        {'stiffening_form': form},
        'stiffening',
        lambda size, random: number(amounts[size], random),
    )


def _contrast(mode: str) -> Form:
    return _drawn(
        'stiffness_contrast',
        mode,
        {'contrast_mode': mode},
        'contrast',
        lambda size, random: signed((0.4, 0.9, 1.8)[size], random),
    )


def _mass(form: str) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        mass, _ = weight_moment(setup)
        return {
            'mass_form': form,
            'added_mass': number(1e3 * mass * (0.05, 0.12, 0.30)[size], random),
            'added_mass_at': round(float(random.uniform(0.5, 0.9)), 3),
        }

    return Form('added_mass', form, draw)


def _give(form: str) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        mass, moment = weight_moment(setup)
        by_turn = float(np.deg2rad((1.0, 3.0, 7.0)[size])) / moment
        by_shift = (0.001, 0.003, 0.006)[size] / (9.81 * mass)
        others = {'shear': by_shift, 'jaw': (0.3, 0.7, 1.3)[size]}
        amount = others.get(form, by_turn)
        return {'clamp_form': form, 'clamp_compliance': number(amount, random)}

    return Form('compliant_clamp', form, draw)


def _tilt(form: str) -> Form:
    return _drawn(
        'gravity_tilt',
        form,
        {'tilt_form': form},
        'gravity_tilt',
        lambda size, random: direction((4.0, 9.0, 18.0)[size], 2, random),
    )


def _curvature(form: str) -> Form:
    return _drawn(
        'rest_curvature',
        form,
        {'curvature_form': form},
        'rest_curvature',
        lambda size, random: direction((0.4, 1.0, 2.5)[size], 2, random),
    )


def _depth(form: str) -> Form:
    return _drawn(
        'depth_affine',
        form,
        {'depth_form': form},
        'depth_bias',
        lambda size, random: signed((1.5, 4.0, 9.0)[size], random),
    )


def _border(name: str, fixed: dict[str, Any]) -> Form:
    return _drawn(
        'depth_bias_by_region',
        name,
        fixed,
        'region_bias',
        lambda size, random: signed((0.8, 2.0, 5.0)[size], random),
    )


def _contact(form: str) -> Form:
    return _drawn(
        'contact_plane',
        form,
        {'contact_form': form},
        'contact_height',
        lambda size, random: number((2.0, 5.0, 11.0)[size], random),
    )


def _camera(name: str, key: str, amounts: tuple[float, float, float]) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        amount = signed(amounts[size], random)
        return {key: amount, 'center_shift': direction((3.0, 7.0, 15.0)[size], 2, random)}

    return Form('camera_offset', name, draw)


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
        _stiffening('gent', (16.0, 40.0, 80.0)),
        _stiffening('cubic', (300.0, 1000.0, 4000.0)),
        _contrast('smooth'),
        _mass('ring'),
        _mass('smear'),
        _give('uneven'),
        _give('shear'),
        Form(
            'camera_offset',
            'focal',
            lambda size, setup, random: {'focal_scale': signed((0.004, 0.01, 0.03)[size], random)},
        ),
        _tilt('side_force'),
        _curvature('tip'),
        _depth('radial'),
        _border('early border', {'region_from': 0.35}),
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
        _stiffening('mooney_rivlin', (0.3, 0.6, 0.9)),
        _stiffening('ogden', (0.2, 0.4, 0.7)),
        _stiffening('fung', (10.0, 30.0, 80.0)),
        _contrast('thirds'),
        _contrast('skin'),
        _mass('point'),
        _give('jaw'),
        Form(
            'camera_offset',
            'lens',
            lambda size, setup, random: {
                'radial_distortion': signed((0.05, 0.1, 0.3)[size], random),
                'center_shift': direction((4.0, 9.0, 20.0)[size], 2, random),
            },
        ),
        _tilt('rig_force'),
        _curvature('twist'),
        _depth('drift'),
        _border('late border', {'region_from': 0.65}),
        Form(
            'clamp_offset',
            'turns on',
            lambda size, setup, random: {
                'clamp_steps': True,
                'clamp_turn': direction((1.0, 2.5, 6.0)[size], 3, random),
            },
        ),
        _contact('foam'),
    ),
    'anew': (
        _contrast('cosine'),
        _mass('two'),
        _give('hardening'),
        _camera('aspect', 'aspect', (0.003, 0.008, 0.02)),
        _tilt('growing'),
        _depth('disparity'),
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
        _contrast('late'),
        _contrast('square'),
        _mass('coat'),
        _give('softening'),
        _tilt('outer_push'),
        _curvature('root'),
        _depth('ramp'),
        _depth('settling'),
        _border('near the tip', {'region_from': 0.78}),
        _camera('focal and centre', 'focal_scale', (0.003, 0.008, 0.02)),
        _contact('shelf'),
    ),
    'sixth': (
        Form('contact_plane', 'edge', _edge),
        _contact('friction'),
        _border('gradual', {'region_ramp': 0.15}),
        Form('camera_offset', 'drifting', _drifting),
        _curvature('S'),
        _curvature('middle'),
        Form('clamp_offset', 'another each pose', _another_each_pose),
        _mass('opposite'),
        _give('about a corner'),
        _contrast('spot'),
        _tilt('changing'),
        Form('depth_affine', 'temperature', _temperature),
    ),
}
# Two at a time, of different effects: some that sets of before had singly, some of the last.
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
