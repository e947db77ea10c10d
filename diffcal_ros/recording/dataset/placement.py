# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the object transform of the public data set means.

The authors' simulator was given the stored rotation as a quaternion in another order: its
(w, x, y, z) was read as (x, y, z, w). That reproduces the start positions of all six experiments
whose simulated states are public. Turning the stored rotation by 180 degrees about the world's x
axis reproduces the same six; the two differ for other experiments, among them the dragon and the
finger, of which no state is public. There the clamp decides: it stands beside the marker, which
is the world's origin.
"""

from diffcal_ros.rigid_transform import (
    angle_between,
    quaternion_xyzw,
    rotation_from_quaternion,
    transform,
)
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ALIKE = np.deg2rad(0.1)
_HALF_TURN_ABOUT_X = np.diag([1.0, -1.0, -1.0])


def world_from_object(
    stored_rotation: FloatArray, translation: FloatArray, clamped: FloatArray
) -> tuple[FloatArray, str | None]:
    """Read a stored placement.

    Args:
        stored_rotation: as in the file, shape (3, 3).
        translation: in the world frame [m], shape (3,).
        clamped: clamped points of the mesh in the object frame [m], shape (n, 3).

    Returns:
        The placement, shape (4, 4), and what to tell the user where it rests on the clamp alone.
    """
    x, y, z, w = quaternion_xyzw(stored_rotation)
    reordered = rotation_from_quaternion(np.array([w, x, y, z]))
    turned = _HALF_TURN_ABOUT_X @ stored_rotation
    if angle_between(reordered, turned) < _ALIKE:
        return transform(reordered, translation), None
    middle = clamped.mean(axis=0)
    distances = [
        float(np.linalg.norm(rotation @ middle + translation)) for rotation in (reordered, turned)
    ]
    nearer = reordered if distances[0] <= distances[1] else turned
    note = (
        'the stored placement can be read in two ways; taken is the one that puts the clamp '
        f'{min(distances) * 1e3:.0f} mm from the marker, not {max(distances) * 1e3:.0f} mm: '
        'look at the drawing of `diffcal check` before you trust it'
    )
    return transform(nearer, translation), note
