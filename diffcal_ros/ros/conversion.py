# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Messages to plain values and back."""

import array
from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Time
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import decode_depth, DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.live.frames.frame_gate import ImageFacts
from diffcal_ros.recording.topics.camera_infos import camera_of
from diffcal_ros.recording.topics.color_frame import ColorFrame, decode_color
from diffcal_ros.rigid_transform import (
    check_rigid,
    quaternion_xyzw,
    rotation_from_quaternion,
    transform,
)
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3
import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header, Int32MultiArray, MultiArrayDimension, MultiArrayLayout

FloatArray = NDArray[np.float64]

_SECOND = 1_000_000_000  # [ns]


def stamp_ns(stamp: Time) -> int:
    """Return a stamp [ns]."""
    return int(stamp.sec) * _SECOND + int(stamp.nanosec)


def stamp_message(time_ns: int) -> Time:
    """Make a stamp."""
    return Time(sec=time_ns // _SECOND, nanosec=time_ns % _SECOND)


def header_message(time_ns: int, frame_id: str) -> Header:
    """Make a header."""
    return Header(stamp=stamp_message(time_ns), frame_id=frame_id)


def image_facts(image: Image) -> ImageFacts:
    """Return what an image says about itself."""
    return ImageFacts(
        encoding=image.encoding,
        width=image.width,
        height=image.height,
        step=image.step,
        byte_count=len(image.data),
        stamp_ns=stamp_ns(image.header.stamp),
        frame_id=image.header.frame_id,
    )


def depth_frame(image: Image) -> DepthFrame:
    """Read a depth image.

    Raises:
        ValueError: for another encoding, or a size that does not fit the data.
    """
    depth = decode_depth(
        image.data,
        encoding=image.encoding,
        width=image.width,
        height=image.height,
        step=image.step,
        is_bigendian=bool(image.is_bigendian),
    )
    return DepthFrame(depth, stamp_ns(image.header.stamp), image.header.frame_id)


def color_frame(image: Image) -> ColorFrame:
    """Read a colour image.

    Raises:
        ValueError: for another encoding, or a size that does not fit the data.
    """
    pixels = decode_color(
        image.data,
        encoding=image.encoding,
        width=image.width,
        height=image.height,
        step=image.step,
    )
    return ColorFrame(pixels, stamp_ns(image.header.stamp), image.header.frame_id)


def depth_camera(info: CameraInfo, topic: str, image_topic: str) -> PinholeCamera:
    """Read a depth camera's camera_info.

    Raises:
        RecordingError: for a zero focal length, or distortion.
    """
    camera = camera_of(info, topic=topic, image_topic=image_topic)
    if camera.is_distorted:
        shown = ', '.join(f'{value:g}' for value in camera.distortion)
        raise RecordingError(
            f'{topic} says that {image_topic} is distorted ({shown}): rectify it (image_proc) '
            'and remap in/depth/image_rect_raw of the depth source to the rectified topic'
        )
    return camera


def image_message(pixels: NDArray[Any], *, encoding: str, time_ns: int, frame_id: str) -> Image:
    """Make an image from rows of pixels, shape (H, W) or (H, W, channels)."""
    little = np.ascontiguousarray(pixels, dtype=pixels.dtype.newbyteorder('<'))
    image = Image(
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        is_bigendian=0,
        step=little.strides[0],
    )
    image.header.stamp = stamp_message(time_ns)
    image.header.frame_id = frame_id
    # Anything but an array of bytes is copied number by number.
    image.data = array.array('B', little.tobytes())
    return image


def camera_info_message(camera: PinholeCamera, *, time_ns: int, frame_id: str) -> CameraInfo:
    """Make the camera_info of a camera without distortion."""
    info = CameraInfo(
        height=camera.height,
        width=camera.width,
        distortion_model='plumb_bob',
        d=[0.0] * 5,
        k=camera.K.ravel(),
        r=np.eye(3).ravel(),
        p=np.hstack([camera.K, np.zeros((3, 1))]).ravel(),
    )
    info.header.stamp = stamp_message(time_ns)
    info.header.frame_id = frame_id
    return info


def pose_matrix(pose: Pose) -> FloatArray:
    """Return header_frame_from_body of a pose, shape (4, 4).

    Raises:
        ValueError: when it is not finite, or its quaternion is zero.
    """
    return _matrix('pose', pose.position, pose.orientation)


def transform_matrix(given: Transform) -> FloatArray:
    """Return parent_from_child of a transform, shape (4, 4).

    Raises:
        ValueError: when it is not finite, or its quaternion is zero.
    """
    return _matrix('transform', given.translation, given.rotation)


def pose_message(matrix: FloatArray) -> Pose:
    """Make a pose."""
    x, y, z = (float(value) for value in matrix[:3, 3])
    return Pose(position=Point(x=x, y=y, z=z), orientation=_quaternion(matrix))


def transform_message(matrix: FloatArray) -> Transform:
    """Make a transform."""
    x, y, z = (float(value) for value in matrix[:3, 3])
    return Transform(translation=Vector3(x=x, y=y, z=z), rotation=_quaternion(matrix))


def seen_message(seen_ids: Sequence[int]) -> Int32MultiArray:
    """Make the list of a marker's or board's parts that were seen."""
    count = len(seen_ids)
    axis = MultiArrayDimension(label='seen parts', size=count, stride=count)
    return Int32MultiArray(layout=MultiArrayLayout(dim=[axis]), data=list(seen_ids))


def _matrix(name: str, shift: Any, turn: Any) -> FloatArray:
    rotation = rotation_from_quaternion(np.array([turn.x, turn.y, turn.z, turn.w]))
    return check_rigid(name, transform(rotation, np.array([shift.x, shift.y, shift.z])))


def _quaternion(matrix: FloatArray) -> Quaternion:
    x, y, z, w = (float(value) for value in quaternion_xyzw(matrix[:3, :3]))
    return Quaternion(x=x, y=y, z=z, w=w)
