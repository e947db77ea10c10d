# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find a target's markers in one colour image."""

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import cv2
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.pose.corner_refinement import refine_corners
from diffcal_ros.pose.dictionary import marker_dictionary
from diffcal_ros.pose.lens import undistort
from diffcal_ros.pose.marker_target import MarkerTarget
from diffcal_ros.pose.target import Target
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


# Measured on rendered markers of 30 to 60 pixels with blur and noise [px]: print, lens and
# detector, not the noise of one frame.
SHARED_ERROR = {
    CornerRefinement.EDGES: 0.1,
    CornerRefinement.SUBPIXEL: 0.5,
    CornerRefinement.NONE: 0.8,
}


@dataclass(frozen=True)
class Detection:
    """What one image shows.

    Attributes:
        corners: by number of the target's part, in the ideal pinhole image (distortion taken
            out) [px], shape (k, 2), in the order of the target's corners; empty where they are
            too few for a pose.
        image_corners: all that was found, in the image itself and unrefined, for drawing [px].
        shared_error: what all frames of a static camera share of the corners' errors: standard
            deviation of a coordinate [px].
        other_ids: markers of the same dictionary that are not of the target.
        hint: what may be wrong with the target where it was not found, or nothing.
    """

    corners: dict[int, FloatArray]
    image_corners: dict[int, FloatArray]
    shared_error: float = SHARED_ERROR[CornerRefinement.EDGES]
    other_ids: tuple[int, ...] = ()
    hint: str = ''


class Detector(Protocol):
    """Finds one target in images of one camera."""

    @property
    def target(self) -> Target:
        """What is looked for."""
        ...

    @property
    def camera(self) -> PinholeCamera:
        """Intrinsics of the colour images."""
        ...

    def detect(self, image: NDArray[np.uint8]) -> Detection:
        """Find the target in one image: BGR, shape (H, W, 3), or grey, shape (H, W).

        Raises:
            PoseError: when the image has another size than the camera.
        """
        ...


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
        gray = gray_image(image, self.camera)
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
            shared_error=SHARED_ERROR[self.refinement],
            other_ids=tuple(sorted(set(found) - set(ours))),
        )

    def _refined(self, gray: NDArray[np.uint8], corners: FloatArray) -> FloatArray | None:
        if self.refinement is not CornerRefinement.EDGES:
            return undistort(corners, self.camera)
        return refine_corners(gray, corners, camera=self.camera, cells=self._cells)


def gray_image(image: NDArray[np.uint8], camera: PinholeCamera) -> NDArray[np.uint8]:
    """Return a colour image in grey, shape (H, W).

    Raises:
        PoseError: when the image has another size than the camera.
    """
    if image.shape[:2] != (camera.height, camera.width):
        raise PoseError(
            f'colour image is {image.shape[1]}x{image.shape[0]}, its camera is '
            f'{camera.width}x{camera.height}: check that camera_info belongs to the colour topic'
        )
    gray = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return np.asarray(gray, dtype=np.uint8)


def _area(corners: FloatArray) -> float:
    return float(cv2.contourArea(corners.astype(np.float32)))
