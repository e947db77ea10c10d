# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find a target's markers in one colour image."""

from dataclasses import dataclass
from enum import Enum

import cv2
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.pose.corner_refinement import refine_corners
from diffcal_ros.pose.dictionary import marker_dictionary
from diffcal_ros.pose.lens import undistort
from diffcal_ros.pose.marker_target import MarkerTarget
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class CornerRefinement(str, Enum):
    """How corners are located.

    `EDGES` intersects lines through the marker's sides. `NONE` takes OpenCV's corners as they
    are, whole pixels half a pixel inside the square, as the public data set's authors did.
    `SUBPIXEL` is OpenCV's own refinement.
    """

    EDGES = 'edges'
    NONE = 'none'
    SUBPIXEL = 'subpixel'


@dataclass(frozen=True)
class Detection:
    """What one image shows.

    Attributes:
        corners: by marker id, in the ideal pinhole image (distortion taken out) [px], shape
            (4, 2), in the order of the target's corners; markers of the target only.
        image_corners: the same in the image itself and unrefined, for drawing [px].
        refinement: how the corners were located.
        other_ids: markers of the same dictionary that are not of the target.
    """

    corners: dict[int, FloatArray]
    image_corners: dict[int, FloatArray]
    refinement: CornerRefinement = CornerRefinement.EDGES
    other_ids: tuple[int, ...] = ()


class MarkerDetector:
    """Finds the markers of one target."""

    def __init__(
        self,
        target: MarkerTarget,
        camera: PinholeCamera,
        refinement: CornerRefinement = CornerRefinement.EDGES,
    ) -> None:
        """Prepare the search.

        Args:
            target: what is looked for.
            camera: intrinsics of the colour images.
            refinement: how corners are located.
        """
        self.target = target
        self.camera = camera
        self.refinement = CornerRefinement(refinement)
        dictionary = marker_dictionary(target.dictionary)
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = (
            cv2.aruco.CORNER_REFINE_SUBPIX
            if self.refinement is CornerRefinement.SUBPIXEL
            else cv2.aruco.CORNER_REFINE_NONE
        )
        self._cells = dictionary.markerSize + 2
        self._detector = cv2.aruco.ArucoDetector(dictionary, parameters)

    def detect(self, image: NDArray[np.uint8]) -> Detection:
        """Find the markers in one image.

        Args:
            image: BGR, shape (H, W, 3), or grey, shape (H, W).

        Raises:
            PoseError: when the image has another size than the camera.
        """
        if image.shape[:2] != (self.camera.height, self.camera.width):
            raise PoseError(
                f'colour image is {image.shape[1]}x{image.shape[0]}, its camera is '
                f'{self.camera.width}x{self.camera.height}: check that camera_info belongs to '
                'the colour topic'
            )
        gray = np.asarray(
            image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8
        )
        quads, ids, _ = self._detector.detectMarkers(gray)
        found: dict[int, FloatArray] = {}
        for marker_id, quad in zip([] if ids is None else ids.ravel(), quads, strict=True):
            corners = np.asarray(quad, dtype=np.float64).reshape(4, 2)
            known = found.get(int(marker_id))
            # Two of one number: the smaller one is a reflection or a false alarm.
            if known is None or _area(corners) > _area(known):
                found[int(marker_id)] = corners
        ours = {key: found[key] for key in self.target.ids if key in found}
        refined = {key: self._refined(gray, corners) for key, corners in ours.items()}
        return Detection(
            corners={key: corners for key, corners in refined.items() if corners is not None},
            image_corners=ours,
            refinement=self.refinement,
            other_ids=tuple(sorted(set(found) - set(ours))),
        )

    def _refined(self, gray: NDArray[np.uint8], corners: FloatArray) -> FloatArray | None:
        if self.refinement is not CornerRefinement.EDGES:
            return undistort(corners, self.camera)
        return refine_corners(gray, corners, camera=self.camera, cells=self._cells)


def _area(corners: FloatArray) -> float:
    return float(cv2.contourArea(corners.astype(np.float32)))
