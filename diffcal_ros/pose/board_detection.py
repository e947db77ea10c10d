# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find a ChArUco board in one colour image."""

from collections.abc import Sequence
from typing import Any

import cv2
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.pose.board_target import BoardTarget
from diffcal_ros.pose.detection import Detection, gray_image
from diffcal_ros.pose.lens import undistort
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What all frames of a static camera share of a corner's error, measured on rendered boards whose
# squares are 20 to 60 pixels, with blur and noise [px].
_SHARED_ERROR = 0.05
# Half sizes of the window in which a corner is refined [px]. It must not reach a marker.
_SMALLEST_WINDOW, _LARGEST_WINDOW = 2, 12
_STOP = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-3)


class BoardDetector:
    """Finds the inner corners of one board, also where a part of it is covered."""

    def __init__(self, target: BoardTarget, camera: PinholeCamera) -> None:
        """Prepare the search.

        Args:
            target: what is looked for.
            camera: intrinsics of the colour images.
        """
        self.target = target
        self.camera = camera
        self._detector = cv2.aruco.CharucoDetector(target.opencv_board())

    def detect(self, image: NDArray[np.uint8]) -> Detection:
        """Find the board in one image.

        Args:
            image: BGR, shape (H, W, 3), or grey, shape (H, W).

        Raises:
            PoseError: when the image has another size than the camera.
        """
        gray = gray_image(image, self.camera)
        pixels, numbers, marker_corners, marker_ids = self._detector.detectBoard(gray)
        ids = [] if marker_ids is None else [int(number) for number in marker_ids.ravel()]
        found: dict[int, FloatArray] = {}
        if numbers is not None:
            window = self._window(marker_corners)
            corners = _refined(gray, np.asarray(pixels, dtype=np.float32), window)
            found = {int(n): c for n, c in zip(numbers.ravel(), corners, strict=True)}
        is_enough = self.target.is_enough(found)
        ideal = {number: undistort(corner, self.camera) for number, corner in found.items()}
        return Detection(
            corners=ideal if is_enough else {},
            image_corners=found,
            shared_error=_SHARED_ERROR,
            other_ids=tuple(sorted(set(ids) - set(self.target.marker_ids))),
            hint='' if found else self._hint(gray, ids),
        )

    def _window(self, marker_corners: Sequence[NDArray[Any]]) -> int:
        """Return half the size of a window around a corner that meets no marker [px]."""
        quads = np.array(marker_corners, dtype=np.float64).reshape(-1, 4, 2)
        sides = np.linalg.norm(quads - np.roll(quads, 1, axis=1), axis=-1)
        # The marker's own corner is as far to the side as it is down.
        margin = 0.5 * (self.target.board.square - self.target.side) / self.target.side
        reach = int(margin * sides.min(axis=1).min())
        return min(max(reach, _SMALLEST_WINDOW), _LARGEST_WINDOW)

    def _hint(self, gray: NDArray[np.uint8], ids: list[int]) -> str:
        """Say what is wrong with the board where its markers are seen and its corners are not."""
        seen = len(set(ids) & set(self.target.marker_ids))
        if not seen:
            return ''
        board = self.target.board
        if board.rows % 2 == 0:
            other = cv2.aruco.CharucoDetector(
                self.target.opencv_board(is_legacy=not board.is_legacy)
            )
            if other.detectBoard(gray)[1] is not None:
                made = 'after' if board.is_legacy else 'before'
                value = str(not board.is_legacy).lower()
                return (
                    f'its pattern is that of OpenCV {made} version 4.6: set `legacy: {value}` '
                    'under `board`'
                )
        return (
            f'{seen} of its {board.marker_count} markers were, but no corner between two of them: '
            'check columns, rows and id, and that the light and the focus are good'
        )


def _refined(gray: NDArray[np.uint8], pixels: NDArray[np.float32], window: int) -> FloatArray:
    """Locate corners where the squares' edges cross [px], shape (n, 1, 2).

    OpenCV's detector counts from a pixel's corner in some versions and from its middle in
    others; from either this ends at the same place, with pixel centres at integers.
    """
    refined = cv2.cornerSubPix(gray, pixels.copy(), (window, window), (-1, -1), _STOP)
    return np.asarray(refined, dtype=np.float64).reshape(-1, 1, 2)
