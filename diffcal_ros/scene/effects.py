# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The library of effects that a model may lack, described as data.

Amplitudes are in SI units here; `shown_unit` and `shown_factor` are for people. All are absent at
zero. A mode that goes with a place along the body has that place as a setting, not as an
amplitude.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

_DEGREE = float(np.deg2rad(1.0))


@dataclass(frozen=True)
class Component:
    """One amplitude of an effect.

    Attributes:
        name: after the dot, as in `clamp_offset.rx`.
        unit: SI.
        lower: bound.
        upper: bound; a lower bound of 0 makes it one-sided.
        scale: what would be called a usual size: the prior's standard deviation.
        shown_unit: for people.
        shown_factor: from SI to that.
        longest_step: of a fit, in scales; tangents of what touches hold over short ways only.
    """

    name: str
    unit: str
    lower: float
    upper: float
    scale: float
    shown_unit: str
    shown_factor: float
    longest_step: float = 3.0


@dataclass(frozen=True)
class Effect:
    """One effect of the library.

    Attributes:
        identifier: as in verdicts and scene files.
        group: sensor, load, boundary, shape, material or dynamics.
        components: its amplitudes.
        sentence: what it means, for a person.
        settles: recordings or measurements each of which would tell it from its twins.
        twins: effects that may look the same.
        settings: fixed numbers that go with it, with their defaults.
        setting_limits: what each of them may be.
        is_searched: a diagnosis looks for it.
        needs_motion: whether a body at rest shows nothing of it.
        needs_hold: whether only a load that is held for long shows it; a swing then does not.
        most_confidence: that its name deserves where a cause outside the library looks the same.
    """

    identifier: str
    group: str
    components: tuple[Component, ...]
    sentence: str
    settles: tuple[str, ...]
    twins: tuple[str, ...]
    settings: dict[str, float] = field(default_factory=dict)
    setting_limits: tuple[float, float] = (0.0, 1.0)
    is_searched: bool = True
    needs_motion: bool = False
    needs_hold: bool = False
    most_confidence: float = 1.0

    def component(self, name: str) -> Component:
        """Return a component by name."""
        return next(part for part in self.components if part.name == name)


def _rigid(shift: float, turn: float, largest: float) -> tuple[Component, ...]:
    shifts = [Component(a, 'm', -largest, largest, shift, 'mm', 1e3) for a in ('x', 'y', 'z')]
    turns = [
        Component(a, 'rad', -np.pi / 3, np.pi / 3, turn, 'deg', 1.0 / _DEGREE)
        for a in ('rx', 'ry', 'rz')
    ]
    return (*shifts, *turns)


_ROLLED = 'a pose with the rig rolled by 90 degrees before the same camera'

_ALL = (
    Effect(
        'camera_offset',
        'sensor',
        _rigid(0.020, 5.0 * _DEGREE, 0.2),
        'the camera is not where it is said to be',
        (_ROLLED, 'the clamp in view and as `fixture` in the scene'),
        ('clamp_offset', 'depth_affine'),
    ),
    Effect(
        'depth_affine',
        'sensor',
        (
            Component('scale', '1', -0.1, 0.1, 0.03, '%', 100.0),
            Component('bias', 'm', -0.05, 0.05, 0.005, 'mm', 1e3),
        ),
        'the depth camera reads too far or too near',
        ('a rigid target at two known distances',),
        ('camera_offset',),
    ),
    Effect(
        'depth_bias_by_region',
        'sensor',
        (Component('bias', 'm', -0.05, 0.05, 0.005, 'mm', 1e3),),
        'the depth camera reads one of the materials too far or too near',
        ('both materials flat on one plane',),
        ('camera_offset', 'clamp_offset'),
        {'at': 0.5},  # Where one of the materials ends, in a scene of one region.
    ),
    Effect(
        'time_offset',
        'sensor',
        (Component('late', 's', -0.2, 0.2, 0.010, 'ms', 1e3),),
        'the stamps of the depth images are late',
        ('a signal that the camera sees and the release clock stamps, such as a light',),
        ('air_drag',),
        needs_motion=True,
    ),
    Effect(
        'gravity_tilt',
        'load',
        tuple(
            Component(a, 'rad', -np.pi / 4, np.pi / 4, 8.0 * _DEGREE, 'deg', 1.0 / _DEGREE)
            for a in ('a', 'b')
        ),
        'the rig is not level, or something steady pushes the body sideways',
        ('a spirit level', _ROLLED),
        ('camera_offset', 'clamp_offset'),
        # Of 14 development cases with this name 10 were tilts, the others a steady side wind.
        most_confidence=0.7,
    ),
    Effect(
        'added_mass',
        'load',
        (Component('mass', 'kg', 0.0, 0.5, 0.010, 'g', 1e3),),
        'something hangs on the body',
        ('the weight of the body', 'a pose with the body upside down'),
        ('stiffness_contrast',),
        {'at': 1.0},
    ),
    Effect(
        'contact_plane',
        'load',
        (
            # As far from the world's origin as a body may be placed.
            Component('height', 'm', -100.0, 100.0, 0.010, 'mm', 1e3, 0.4),
            *(
                Component(
                    a, 'rad', -np.pi / 4, np.pi / 4, 5.0 * _DEGREE, 'deg', 1.0 / _DEGREE, 0.6
                )
                for a in ('a', 'b')
            ),
        ),
        'the body lies on something',
        ('a pose in which it cannot touch',),
        ('added_mass',),
    ),
    Effect(
        'clamp_offset',
        'boundary',
        _rigid(0.005, 3.0 * _DEGREE, 0.2),
        'the body sits elsewhere in the clamp than the scene says',
        (_ROLLED,),
        ('camera_offset', 'rest_curvature'),
    ),
    Effect(
        'compliant_clamp',
        'boundary',
        (Component('compliance', 'rad/(N m)', 0.0, 100.0, 5.0, 'rad/(N m)', 1.0),),
        'the clamp gives way under the load',
        ('a second load', 'a pose that loads the clamp otherwise'),
        ('clamp_offset', 'stiffness_contrast'),
    ),
    Effect(
        'rest_curvature',
        'shape',
        tuple(Component(a, '1/m', -20.0, 20.0, 2.0, '1/m', 1.0) for a in ('a', 'b')),
        'the body is bent when nothing pulls on it',
        ('a pose with the body rolled by 180 degrees',),
        ('clamp_offset', 'gravity_tilt'),
    ),
    Effect(
        'stiffness_contrast',
        'material',
        (
            Component('split', '1', -4.0, 4.0, 1.0, 'log E', 1.0),
            Component('along', '1', -4.0, 4.0, 1.0, 'log E', 1.0),
        ),
        'one part of the body is stiffer than another',
        ('a twist besides the bend',),
        ('added_mass', 'compliant_clamp'),
        {'at': 0.5},  # As above.
    ),
    Effect(
        'strain_stiffening',
        'material',
        (Component('ratio', '1', 0.0, 300.0, 30.0, 'C2/C1', 1.0),),
        'the material stiffens when it is strained',
        ('a second load that strains it less',),
        ('stiffness_contrast',),
    ),
    # One load of one body cannot tell it from another modulus.
    Effect(
        'anisotropy',
        'material',
        (Component('ratio', '1', 0.0, 100.0, 3.0, 'added stiffness / G', 1.0),),
        'the material is stiffer along one direction',
        ('a twist besides the bend', 'loads along and across that direction'),
        ('stiffness_contrast',),
        {'x': 0.0, 'y': 0.0, 'z': 0.0},  # Of the object frame; all zero: along the body.
        (-1.0, 1.0),
        is_searched=False,
    ),
    Effect(
        'creep',
        'material',
        (
            Component('share', '1', 0.0, 0.9, 0.1, '%', 100.0),
            Component('tau', 's', 0.0, 1e5, 10.0, 's', 1.0),
        ),
        'the material yields slowly under a load that is held',
        ('a load held for three times as long',),
        ('added_mass', 'clamp_offset'),
        needs_motion=True,
        needs_hold=True,
    ),
    Effect(
        'air_drag',
        'dynamics',
        (Component('area', 'm^2', 0.0, 2.0, 0.020, 'cm^2', 1e4),),
        'the air holds the moving body back',
        ('a second release with half the swing',),
        ('time_offset',),
        needs_motion=True,
    ),
)
EFFECTS = {effect.identifier: effect for effect in _ALL}
# Those that the fit names by other words of longer standing.
FIT_NAME_OF = {'camera_offset': 'rigid_offset'}


def amplitude_name(identifier: str, component: str) -> str:
    """Return the name of an amplitude among the parameters of a fit."""
    return f'{FIT_NAME_OF.get(identifier, identifier)}.{component}'


def what_settles(identifiers: Iterable[str]) -> str:
    """Say what to record or measure to tell effects from their twins."""
    ways = (way for name in identifiers for way in EFFECTS[name].settles)
    return ', or '.join(dict.fromkeys(ways))
