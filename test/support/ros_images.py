# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Messages of a small depth camera, good ones that tests then spoil."""

import array
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.ros.conversion import camera_info_message, image_message, pose_message
from geometry_msgs.msg import PoseWithCovarianceStamped
import numpy as np
from sensor_msgs.msg import CameraInfo, Image

CAMERA = PinholeCamera(64, 48, 60.0, 61.0, 31.5, 24.25)
FRAME = 'camera_depth_optical_frame'
PERIOD = 33_333_333  # [ns]
START = 1_700_000_000_000_000_000  # [ns]


def depth_image(number: int = 0, *, depth: float = 0.4, **changes: Any) -> Image:
    """A flat wall, the left half of it not seen; `changes` replaces fields."""
    pixels = np.full((CAMERA.height, CAMERA.width), depth, dtype=np.float32)
    pixels[:, : CAMERA.width // 2] = np.nan
    stamp = START + number * PERIOD
    image = image_message(pixels, encoding='32FC1', time_ns=stamp, frame_id=FRAME)
    for name, value in changes.items():
        setattr(image, name, value)
    return image


def millimetre_image(number: int = 0, *, is_bigendian: bool) -> Image:
    """The same wall in 16UC1."""
    pixels = np.full((CAMERA.height, CAMERA.width), 400, dtype='>u2' if is_bigendian else '<u2')
    pixels[:, : CAMERA.width // 2] = 0
    return depth_image(
        number,
        encoding='16UC1',
        step=2 * CAMERA.width,
        is_bigendian=int(is_bigendian),
        data=array.array('B', pixels.tobytes()),
    )


def camera_info(camera: PinholeCamera = CAMERA) -> CameraInfo:
    return camera_info_message(camera, time_ns=START, frame_id=FRAME)


def world_pose(camera_from_world: np.ndarray) -> PoseWithCovarianceStamped:
    """A pose in the depth camera's own frame, taken as exact."""
    message = PoseWithCovarianceStamped()
    message.header.frame_id = FRAME
    message.pose.pose = pose_message(camera_from_world)
    return message
