# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a synthetic camera stands, and what it is like."""

from collections.abc import Sequence

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import InputError
from diffcal_ros.marker import Marker
from diffcal_ros.rigid_transform import apply, inverse, looking_at, rotation_matrix, transform
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Like the Intel L515's; every copy of it differs by a few pixels.
DEPTH_CAMERA = PinholeCamera(1024, 768, fx=731.5, fy=732.75, cx=515.25, cy=389.0)
COLOR_CAMERA = PinholeCamera(1280, 720, fx=903.0, fy=902.25, cx=645.5, cy=357.75)
# The lenses sit 14 mm apart and not quite parallel.
DEPTH_FROM_COLOR = transform(
    rotation_matrix(np.deg2rad([-1.4, 0.3, 0.7])), np.array([0.0009, -0.0140, 0.0022])
)
# A marker that is seen squarely has two poses that look alike; turned by this much it has one.
_AZIMUTH, _ELEVATION = np.deg2rad(24.0), np.deg2rad(16.0)
_FILLED = 0.84  # Share of the image's width or height that the view takes.
_CLOSEST = 0.26  # The L515 sees nothing nearer than a quarter of a metre.


def default_view(
    points_world: FloatArray,
    outward: FloatArray,
    gravity: FloatArray,
    marker: Marker | None,
    depth_camera: PinholeCamera,
    color_camera: PinholeCamera,
) -> FloatArray:
    """Return `depth_from_world`, shape (4, 4), of a camera that sees some points.

    Args:
        points_world: to be seen by both cameras [m], shape (n, 3).
        outward: from the clamp to the body [m], shape (3,); the camera stands on that side, so
            that the clamp does not hide the body.
        gravity: points down in the picture [m/s^2], shape (3,).
        marker: is looked at from its front, or None.
        depth_camera: intrinsics.
        color_camera: intrinsics.
    """
    up = _up(gravity)
    front = _front(points_world, up, marker)
    side = np.cross(up, front)
    side *= 1.0 if float(side @ outward) >= 0.0 else -1.0
    direction = (
        np.cos(_ELEVATION) * (np.cos(_AZIMUTH) * front + np.sin(_AZIMUTH) * side)
        + np.sin(_ELEVATION) * up
    )
    return _from_far_enough(points_world, direction, up, (depth_camera, color_camera))


def view_from(
    position_world: FloatArray, points_world: FloatArray, gravity: FloatArray
) -> FloatArray:
    """Return `depth_from_world` of a camera at a place, which looks at the middle of points.

    Raises:
        InputError: when it stands above or below the middle, or in it.
    """
    up = _up(gravity)
    middle = 0.5 * (points_world.min(axis=0) + points_world.max(axis=0))
    offset = position_world - middle
    if np.linalg.norm(np.cross(offset, up)) < 1e-3 * max(float(np.linalg.norm(offset)), 1e-3):
        raise InputError(
            f'the camera stands at {position_world.tolist()}, straight above, below or in what '
            f'it looks at ({np.round(middle, 3).tolist()}): move it to a side'
        )
    return looking_at(middle, offset, up)


def _up(gravity: FloatArray) -> FloatArray:
    strength = float(np.linalg.norm(gravity))
    return -gravity / strength if strength > 0.0 else np.array([0.0, 1.0, 0.0])


def _front(points_world: FloatArray, up: FloatArray, marker: Marker | None) -> FloatArray:
    """Return the level direction from which the points are seen broadside, shape (3,)."""
    front = np.zeros(3)
    if marker is not None:
        front = marker.world_from_marker[:3, 2] - (marker.world_from_marker[:3, 2] @ up) * up
    if np.linalg.norm(front) < 0.2:
        _, _, axes = np.linalg.svd(points_world - points_world.mean(axis=0), full_matrices=False)
        # The longest axis that is not upright.
        along = next(axis for axis in axes if abs(float(axis @ up)) < 0.8)
        front = np.cross(along, up)
    unit: FloatArray = front / np.linalg.norm(front)
    return unit


def _from_far_enough(
    points_world: FloatArray,
    direction: FloatArray,
    up: FloatArray,
    cameras: Sequence[PinholeCamera],
) -> FloatArray:
    """Stand back until every camera sees all points."""
    middle = 0.5 * (points_world.min(axis=0) + points_world.max(axis=0))
    rotation = looking_at(middle, direction, up)[:3, :3]
    right, down, ahead = rotation @ (points_world - middle).T
    needed = [_CLOSEST - float(ahead.min())]
    for camera in cameras:
        across = _FILLED * min(camera.cx, camera.width - 1 - camera.cx) / camera.fx
        upright = _FILLED * min(camera.cy, camera.height - 1 - camera.cy) / camera.fy
        needed.append(float((np.abs(right) / across - ahead).max()))
        needed.append(float((np.abs(down) / upright - ahead).max()))
    return looking_at(middle, max(needed) * direction, up)


def sees(camera: PinholeCamera, camera_from_world: FloatArray, points_world: FloatArray) -> bool:
    """Tell whether all points are in front of a camera and inside its image."""
    points = apply(camera_from_world, points_world)
    if points[:, 2].min() <= 0.0:
        return False
    pixels = camera.project(points)
    size = np.array([camera.width - 1, camera.height - 1])
    return bool(((pixels >= 0.0) & (pixels <= size)).all())


def color_from_world(depth_from_world: FloatArray) -> FloatArray:
    """Return the pose of the colour camera beside a depth camera, shape (4, 4)."""
    return inverse(DEPTH_FROM_COLOR) @ depth_from_world
