# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draw what was found into a colour image: markers and the axes of their frame."""

import cv2
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.pose.detection import Detection
from diffcal_ros.pose.lens import distort
from diffcal_ros.rigid_transform import apply
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ByteArray = NDArray[np.uint8]

_OUTLINE = (0, 200, 255)  # BGR.
_AXES = ((60, 60, 235), (80, 190, 60), (235, 130, 50))  # x, y, z.
_SUBPIXEL = 4  # Binary digits of a pixel's fraction that OpenCV draws with.


def draw_pose(
    image: ByteArray,
    camera: PinholeCamera,
    detection: Detection,
    camera_from_marker: FloatArray | None,
    *,
    length: float,
) -> ByteArray:
    """Draw onto a copy of an image.

    Args:
        image: BGR, shape (H, W, 3).
        camera: its intrinsics.
        detection: outlined, or a ring around each corner of a board, with the numbers.
        camera_from_marker: pose whose axes are drawn, shape (4, 4), or None.
        length: of the axes [m].
    """
    drawn = image.copy()
    width = max(1, camera.width // 400)
    for marker_id, corners in detection.image_corners.items():
        if len(corners) == 1:
            _ring(drawn, corners[0], _OUTLINE, width)
        else:
            _line(drawn, corners, _OUTLINE, width, is_closed=True)
        place = (int(corners[0, 0]), int(corners[0, 1]) - 2 * width)
        cv2.putText(
            drawn,
            str(marker_id),
            place,
            cv2.FONT_HERSHEY_SIMPLEX,
            0.4 * width,
            _OUTLINE,
            width,
            cv2.LINE_AA,
        )
    if camera_from_marker is not None:
        ends = apply(camera_from_marker, np.vstack([np.zeros((1, 3)), length * np.eye(3)]))
        if ends[:, 2].min() > 0.0:
            pixels = distort(camera.project(ends), camera)
            for axis, color in enumerate(_AXES):
                _line(drawn, pixels[[0, axis + 1]], color, 2 * width, is_closed=False)
    return drawn


def _ring(image: ByteArray, pixel: FloatArray, color: tuple[int, int, int], width: int) -> None:
    column, row = np.rint(pixel * 2**_SUBPIXEL).astype(int).tolist()
    radius = 3 * width * 2**_SUBPIXEL
    cv2.circle(image, (column, row), radius, color, width, cv2.LINE_AA, _SUBPIXEL)


def _line(
    image: ByteArray,
    pixels: FloatArray,
    color: tuple[int, int, int],
    width: int,
    *,
    is_closed: bool,
) -> None:
    points = np.rint(pixels * 2**_SUBPIXEL).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(image, [points], is_closed, color, width, cv2.LINE_AA, _SUBPIXEL)
