# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Lens distortion in and out, on pixels of one camera."""

import cv2
from diffcal_ros.camera import PinholeCamera
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Corrections after OpenCV's five rounds, which leave up to 0.1 px near the corners of wide lenses.
_ROUNDS = 10


def distort(pixels: FloatArray, camera: PinholeCamera) -> FloatArray:
    """Move pixels of the ideal pinhole image to where the lens puts them, shape (..., 2)."""
    if not camera.is_distorted:
        return pixels
    return _bent(_on_unit_plane(pixels, camera), camera) * _focal(camera) + _middle(camera)


def undistort(pixels: FloatArray, camera: PinholeCamera) -> FloatArray:
    """Move observed pixels to where an ideal pinhole would have seen them, shape (..., 2)."""
    if not camera.is_distorted:
        return pixels
    observed = _on_unit_plane(pixels, camera)
    first = cv2.undistortPoints(
        np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2),
        camera.K,
        np.array(camera.distortion),
    )
    ideal = np.asarray(first, dtype=np.float64).reshape(observed.shape)
    for _ in range(_ROUNDS):
        ideal = ideal + observed - _bent(ideal, camera)
    return ideal * _focal(camera) + _middle(camera)


def _bent(points: FloatArray, camera: PinholeCamera) -> FloatArray:
    """Apply the distortion to points of the plane z = 1, shape (..., 2)."""
    flat = points.reshape(-1, 2)
    lifted = np.hstack([flat, np.ones((len(flat), 1))])
    bent, _ = cv2.projectPoints(
        lifted, np.zeros(3), np.zeros(3), np.eye(3), np.array(camera.distortion)
    )
    return np.asarray(bent, dtype=np.float64).reshape(points.shape)


def _on_unit_plane(pixels: FloatArray, camera: PinholeCamera) -> FloatArray:
    return (np.asarray(pixels, dtype=np.float64) - _middle(camera)) / _focal(camera)


def _focal(camera: PinholeCamera) -> FloatArray:
    return np.array([camera.fx, camera.fy])


def _middle(camera: PinholeCamera) -> FloatArray:
    return np.array([camera.cx, camera.cy])
