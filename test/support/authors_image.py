# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The image errors of the authors' own renderer, copied by name for comparison only.

Their images hold the distance along the ray instead of z; the row of the optical axis is scaled
by the image's aspect ratio; and pixel centres lie at halves while the intrinsics of the sensor
put them at integers. They cast 16 rays a pixel, so a sliver of body may show no ray. The captures
themselves have none of this: never fit with it.
"""

from dataclasses import replace

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_RAY_FRACTION = 1.0 / 16.0


def authors_camera(camera: PinholeCamera) -> PinholeCamera:
    """Return the camera as the authors' renderer took it."""
    middle = camera.height / 2.0
    stretched = middle + (camera.cy - middle) * camera.width / camera.height
    return replace(camera, cx=camera.cx - 0.5, cy=stretched - 0.5)


def authors_image(
    points_camera: FloatArray, triangles: NDArray[np.int32], camera: PinholeCamera
) -> FloatArray:
    """Render as the authors do: distance along the ray [m], 0 beside the body, edges averaged.

    Args:
        points_camera: vertices in the camera frame [m], shape (N, 3).
        triangles: outward, shape (F, 3).
        camera: the sensor's true intrinsics.
    """
    theirs = authors_camera(camera)
    trace = DepthTracer(triangles, len(points_camera), theirs).trace(points_camera)
    mean = trace.area_image(background=0.0).image
    mean[mean < 0.5 * _RAY_FRACTION * float(np.nanmin(trace.depth))] = 0.0
    image = np.zeros((camera.height, camera.width))
    image[trace.rows, trace.columns] = mean
    return ray_length(image, theirs)


def ray_length(depth: FloatArray, camera: PinholeCamera) -> FloatArray:
    """Turn z [m], shape (H, W), into the distance along each pixel's ray [m]."""
    return depth * np.linalg.norm(camera.rays(), axis=-1)
