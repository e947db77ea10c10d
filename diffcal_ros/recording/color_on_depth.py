# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A recording's colour image laid over its depth image."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.pose.lens import distort
from diffcal_ros.recording.recording import Recording
from diffcal_ros.rigid_transform import apply, inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ByteArray = NDArray[np.uint8]

# Nearer to the colour camera than this nothing is seen [m].
_NEAREST = 0.01


def color_on_depth(
    recording: Recording, depth: NDArray[np.floating], camera: PinholeCamera
) -> tuple[ByteArray, NDArray[np.bool_]] | None:
    """Say which colour each pixel of a depth image has.

    What hides a point from the colour camera alone lends it its colour: with both cameras in one
    housing that is a seam of a few pixels.

    Args:
        recording: whose first good colour image is taken.
        depth: z [m], shape (H, W); NaN where invalid.
        camera: intrinsics of the depth image.

    Returns:
        RGB, shape (H, W, 3), and where it is known, shape (H, W); None where the recording has no
        colour image, or does not say where its camera was or what lens it had.
    """
    color_camera, depth_from_color = recording.color_camera, recording.depth_from_color
    if color_camera is None or depth_from_color is None:
        return None
    frame = next(iter(recording.color_frames(limit=1)), None)
    if frame is None:
        return None
    points = apply(inverse(depth_from_color), camera.back_project(depth.astype(np.float64)))
    is_ahead = points[..., 2] > _NEAREST  # NaN is not.
    pixels = np.round(distort(color_camera.project(points[is_ahead]), color_camera)).astype(int)
    columns, rows = pixels[:, 0], pixels[:, 1]
    is_inside = (columns >= 0) & (columns < color_camera.width)
    is_inside &= (rows >= 0) & (rows < color_camera.height)
    is_known = np.zeros(depth.shape, dtype=bool)
    is_known[is_ahead] = is_inside
    colors = np.zeros((*depth.shape, 3), dtype=np.uint8)
    colors[is_known] = frame.image[rows[is_inside], columns[is_inside], ::-1]  # BGR.
    return colors, is_known
