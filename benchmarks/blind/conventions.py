# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A label's amplitudes as a verdict would state them: its components, units, points and axes."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks.blind.rotations import rotation
from benchmarks.blind.shapes import FloatArray

_SIX = ('x', 'y', 'z', 'rx', 'ry', 'rz')
_RENAMED = {
    'clamp_offset': {
        **{f'shift_{axis}': axis for axis in 'xyz'},
        **{f'turn_{axis}': f'r{axis}' for axis in 'xyz'},
    },
    'depth_bias_by_region': {'tip': 'bias'},
}
_MODES = {'split': 'split', 'linear': 'along'}


def true_components(label: Mapping[str, Any], effect: Mapping[str, Any]) -> dict[str, float]:
    """Return what a perfect verdict would say of a label's first effect, by component.

    Args:
        label: of the case.
        effect: as the verdict names it, with its `frame`.
    """
    true = label['effects'][0]
    name, amplitude = true['identifier'], true['amplitude']
    frame = {key: np.array(value) for key, value in effect.get('frame', {}).items()}
    if name == 'camera_offset':
        center = np.array(label['camera_center'])
        return dict(zip(_SIX, _seen_motion(amplitude, center, frame['about']), strict=True))
    if name == 'gravity_tilt':
        return _along((amplitude['x'], 0.0, amplitude['z']), frame)
    if name == 'rest_curvature':
        return _along((0.0, amplitude['y'], amplitude['z']), frame)
    if name == 'creep':
        return {'share': 100.0 * amplitude['share'], 'tau': amplitude['tau']}
    if name == 'contact_plane':
        return {'height': 1e3 * amplitude['height']}
    if name == 'stiffness_contrast':
        return {_MODES[amplitude['mode']]: amplitude['log_ratio']}
    renamed = _RENAMED.get(name, {})
    # Where an added mass sits is no size.
    return {renamed.get(key, key): value for key, value in amplitude.items() if key != 'at'}


def _seen_motion(amplitude: Mapping[str, float], center: FloatArray, about: FloatArray) -> Any:
    """Return how the body seems to move when the camera does, shape (6,) [mm, deg].

    The label says what the camera does, about its centre; a verdict what its picture does, about
    a point of its own.
    """
    shift = 1e-3 * np.array([amplitude[f'shift_{axis}'] for axis in 'xyz'])
    turn = np.array([amplitude[f'turn_{axis}'] for axis in 'xyz'])
    back = rotation(np.deg2rad(turn)).T
    seen = back @ (about - center - shift) + center - about
    return np.concatenate([1e3 * seen, -turn])


def _along(vector: tuple[float, float, float], frame: Mapping[str, FloatArray]) -> Any:
    return {name: float(np.array(vector) @ frame[name]) for name in ('a', 'b')}
