# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From sensor_msgs/CameraInfo to a camera."""

from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import RecordingError
from diffcal_ros.plain_text import listed, plain
from diffcal_ros.recording.topics.names import plain_topic
import numpy as np

_MODELS = ('plumb_bob', 'rational_polynomial', '')
# As many as OpenCV takes.
_COEFFICIENTS = (4, 5, 8, 12, 14)


def camera_of(info: Any, *, topic: str, image_topic: str) -> PinholeCamera:
    """Turn a camera_info into a camera.

    For an image that is rectified by name, and whose projection differs from the raw intrinsics,
    the projection is the camera and there is no distortion (as image_pipeline has it).

    Args:
        info: the message.
        topic: where it was found, for messages.
        image_topic: the images it is for.

    Raises:
        RecordingError: for a zero focal length or a lens model that is not known.
    """
    K = np.asarray(info.k, dtype=np.float64).reshape(3, 3)
    P = np.asarray(info.p, dtype=np.float64).reshape(3, 4)
    distortion = np.asarray(info.d, dtype=np.float64)
    is_rectified = 'rect' in plain_topic(image_topic).rpartition('/')[2] and P[0, 0] > 0.0
    if is_rectified and np.abs(P[:, :3] - K).max() > 1e-6 * np.abs(K).max():
        K, distortion = P[:, :3], np.zeros(0)
    if distortion.any() and info.distortion_model not in _MODELS:
        raise RecordingError(
            f'{topic} has the lens model {plain(info.distortion_model)!r}: plumb_bob and '
            'rational_polynomial are known; give the rectified image topic'
        )
    if distortion.any() and len(distortion) not in _COEFFICIENTS:
        raise RecordingError(
            f'{topic} has {len(distortion)} distortion coefficients: a lens model has '
            f'{listed([str(count) for count in _COEFFICIENTS])}; calibrate the camera again, or '
            'give the rectified image topic'
        )
    try:
        return PinholeCamera(
            width=int(info.width),
            height=int(info.height),
            fx=float(K[0, 0]),
            fy=float(K[1, 1]),
            cx=float(K[0, 2]),
            cy=float(K[1, 2]),
            distortion=tuple(float(value) for value in distortion) if distortion.any() else (),
        )
    except ValueError as error:
        raise RecordingError(f'{topic}: {error}') from error


def require_undistorted(camera: PinholeCamera, *, topic: str, image_topic: str) -> None:
    """Refuse a depth camera with distortion: depth is rendered without.

    Raises:
        RecordingError: asking for the rectified topic.
    """
    if camera.is_distorted:
        shown = ', '.join(f'{value:g}' for value in camera.distortion)
        raise RecordingError(
            f'{topic} says that {image_topic} is distorted ({shown}): record the rectified depth '
            'topic (image_rect) and choose it with --depth-topic'
        )


def require_size(
    camera: PinholeCamera,
    width: int,
    height: int,
    *,
    topic: str,
    image_topic: str,
    cure: str = 'record the camera_info that belongs to the images',
) -> None:
    """Refuse a camera of another size than its images.

    Raises:
        RecordingError: naming both sizes.
    """
    if (camera.width, camera.height) != (width, height):
        raise RecordingError(
            f'{topic} is for {camera.width}x{camera.height} pixels, but {image_topic} has '
            f'{width}x{height}: {cure}'
        )
