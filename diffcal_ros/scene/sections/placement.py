# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigid transforms of the scene file."""

from diffcal_ros.rigid_transform import (
    check_rigid,
    rotation_from_quaternion,
    rotation_matrix,
    transform,
)
from diffcal_ros.scene.reading.problems import listed
from diffcal_ros.scene.reading.section import finite_numbers, Section
from diffcal_ros.scene.reading.shapes import Interval, Keys, ListOf, vector
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ROTATIONS = ('rotation_matrix', 'quaternion_xyzw', 'rotation_vector_deg')
# Positions of a rig in metres; beyond a hundred they are in another unit.
NEAR = Interval(-100.0, 100.0)
_ANGLES = Interval(-360.0, 360.0)
_UNIT_LENGTH_TOLERANCE = 0.01  # Beyond it a number is mistyped, not rounded.


def placement_shape(about: str) -> Keys:
    """Return the shape of a rigid transform: a translation and at most one rotation."""
    return Keys(
        {
            'translation': vector(3, '[x, y, z] in m', NEAR),
            'rotation_matrix': ListOf(vector(3, 'a row'), 'three rows', fewest=3, most=3),
            'quaternion_xyzw': vector(4, '[x, y, z, w] of length 1'),
            'rotation_vector_deg': vector(3, 'axis times angle in degrees', _ANGLES),
        },
        ('translation',),
        about,
    )


def read_placement(section: Section) -> FloatArray | None:
    """Read {translation, one rotation} as a matrix, shape (4, 4); None when it is wrong."""
    translation = section.vector('translation', needed='give three numbers in metres, [x, y, z]')
    given = [name for name in _ROTATIONS if section.has(name)]
    if len(given) > 1:
        section.problems.add(section.key, f'has {listed(given)}: keep one of them')
    rotation = _read_rotation(section, given[0]) if given else np.eye(3)
    section.refuse_unknown()
    if rotation is None or not section.is_sound:
        return None
    return transform(rotation, translation)


def _read_rotation(section: Section, name: str) -> FloatArray | None:
    if name == 'rotation_vector_deg':
        needed = 'give axis times angle in degrees, [x, y, z], each within -360 to 360'
        degrees = section.vector(name, needed=needed)
        return rotation_matrix(np.deg2rad(degrees))
    if name == 'quaternion_xyzw':
        quaternion = section.vector(name, needed='give four numbers, [x, y, z, w]')
        if abs(np.linalg.norm(quaternion) - 1.0) > _UNIT_LENGTH_TOLERANCE:
            section.wrong(name, 'give four numbers [x, y, z, w] of length 1')
            return None
        return rotation_from_quaternion(quaternion)
    return _read_matrix(section, name)


def _read_matrix(section: Section, name: str) -> FloatArray | None:
    needed = 'give three rows of three numbers'
    value = section.raw(name)
    rows = [finite_numbers(row, 3) for row in value] if isinstance(value, list) else []
    sound = [row for row in rows if row is not None]
    if len(rows) != 3 or len(sound) != 3:
        section.wrong(name, needed)
        return None
    try:
        checked = check_rigid(section.at(name), transform(np.array(sound), np.zeros(3)))
    except ValueError as error:
        # The message starts with the key already.
        section.problems.add(section.at(name), str(error).removeprefix(section.at(name)).strip())
        return None
    # Files carry a few digits; the nearest rotation has none of their rounding.
    left, _, right = np.linalg.svd(checked[:3, :3])
    rotation: FloatArray = left @ right
    return rotation
