# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shifts and turns: six amplitudes that two effects have alike."""

from diffcal_ros.effects.effect import Component, DEGREE, FloatArray, Numbers
import numpy as np

SHIFT, TURN = ('x', 'y', 'z'), ('rx', 'ry', 'rz')
RIGID_AXES = SHIFT + TURN
ROLLED = 'a pose with the rig rolled by 90 degrees before the same camera'
_FARTHEST, _MOST_TURNED = 0.2, float(np.pi / 3)


def rigid_components(shift: float, turn: float) -> tuple[Component, ...]:
    """Return the amplitudes of a rigid motion of usual shift [m] and turn [rad]."""
    shifts = [Component(a, 'm', -_FARTHEST, _FARTHEST, shift, 'mm', 1e3) for a in SHIFT]
    turns = [
        Component(a, 'rad', -_MOST_TURNED, _MOST_TURNED, turn, 'deg', 1.0 / DEGREE) for a in TURN
    ]
    return (*shifts, *turns)


def tilt_components(scale: float) -> tuple[Component, ...]:
    """Return two turns of a usual size [rad] about axes across gravity."""
    most, shown = float(np.pi / 4), 1.0 / DEGREE
    return tuple(Component(a, 'rad', -most, most, scale, 'deg', shown) for a in ('a', 'b'))


def twist_of(own: Numbers) -> FloatArray:
    """Return shift [m] and turn [rad], shape (6,)."""
    return np.array([own.get(axis, 0.0) for axis in RIGID_AXES])


def pair_of(own: Numbers) -> FloatArray:
    """Return the amplitudes `a` and `b`, shape (2,)."""
    return np.array([own.get(axis, 0.0) for axis in ('a', 'b')])
