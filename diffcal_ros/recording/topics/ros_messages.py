# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""ROS 2 messages to and from bytes (CDR) without a ROS installation."""

from functools import cache
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.recording.topics.names import CAMERA_INFO_TYPE, IMAGE_TYPE, TRANSFORM_TYPE
from diffcal_ros.rigid_transform import quaternion_xyzw, rotation_from_quaternion, transform
import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import get_typestore, Stores
from rosbags.typesys.store import Typestore

FloatArray = NDArray[np.float64]

_SECOND = 1_000_000_000  # [ns]
# ROS 2 bounds seconds to 32 bits.
_LATEST_STAMP = 2**31 * _SECOND


@cache
def _types() -> Typestore:
    return get_typestore(Stores.ROS2_JAZZY)


def message(type_name: str, **fields: Any) -> Any:
    """Make a message, for example `message('std_msgs/msg/Float64', data=0.5)`."""
    return _types().types[type_name](**fields)


def serialize(msg: Any) -> bytes:
    """Turn a message into CDR bytes."""
    return bytes(_types().serialize_cdr(msg, msg.__msgtype__))


def deserialize(data: bytes, type_name: str) -> Any:
    """Turn CDR bytes into a message.

    Raises:
        ValueError: when the bytes are no such message.
    """
    try:
        return _types().deserialize_cdr(data, type_name)
    except Exception as error:  # The decoder raises what its byte handling happens to raise.
        raise ValueError(f'the message is no {type_name}: {error}') from error


def definition(type_name: str) -> str:
    """Return a type's definition as bags carry it, in the ros2msg format."""
    text, _ = _types().generate_msgdef(type_name, ros_version=2)
    return text


def type_hash(type_name: str) -> str:
    """Return a type's RIHS01 hash."""
    return _types().hash_rihs01(type_name)


def header(stamp_ns: int, frame_id: str) -> Any:
    """Make a std_msgs/Header."""
    if not 0 <= stamp_ns < _LATEST_STAMP:
        raise ValueError(f'stamp is {stamp_ns} ns: ROS holds 0 to {_LATEST_STAMP - 1}')
    stamp = message(
        'builtin_interfaces/msg/Time', sec=stamp_ns // _SECOND, nanosec=stamp_ns % _SECOND
    )
    return message('std_msgs/msg/Header', stamp=stamp, frame_id=frame_id)


def stamp_ns_of(msg: Any) -> int:
    """Return the header's stamp [ns]."""
    return int(msg.header.stamp.sec) * _SECOND + int(msg.header.stamp.nanosec)


def image_message(pixels: NDArray[Any], *, encoding: str, stamp_ns: int, frame_id: str) -> Any:
    """Make a sensor_msgs/Image from rows of pixels, little-endian.

    Args:
        pixels: shape (H, W) or (H, W, channels), of the encoding's type.
        encoding: as sensor_msgs names it.
        stamp_ns: time of exposure [ns].
        frame_id: optical frame.
    """
    little = np.ascontiguousarray(pixels, dtype=pixels.dtype.newbyteorder('<'))
    return message(
        IMAGE_TYPE,
        header=header(stamp_ns, frame_id),
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        is_bigendian=0,
        step=little.strides[0],
        data=little.reshape(-1).view(np.uint8),
    )


def camera_info_message(camera: PinholeCamera, *, stamp_ns: int, frame_id: str) -> Any:
    """Make a sensor_msgs/CameraInfo."""
    known = len(camera.distortion) or 5
    return message(
        CAMERA_INFO_TYPE,
        header=header(stamp_ns, frame_id),
        height=camera.height,
        width=camera.width,
        distortion_model='plumb_bob' if known <= 5 else 'rational_polynomial',
        d=np.array(camera.distortion or [0.0] * 5, dtype=np.float64),
        k=camera.K.ravel(),
        r=np.eye(3).ravel(),
        p=np.hstack([camera.K, np.zeros((3, 1))]).ravel(),
        binning_x=0,
        binning_y=0,
        roi=message(
            'sensor_msgs/msg/RegionOfInterest',
            x_offset=0,
            y_offset=0,
            height=0,
            width=0,
            do_rectify=False,
        ),
    )


def transform_message(
    parent_from_child: FloatArray, *, parent: str, child: str, stamp_ns: int
) -> Any:
    """Make a geometry_msgs/TransformStamped."""
    x, y, z, w = (float(value) for value in quaternion_xyzw(parent_from_child[:3, :3]))
    shift = parent_from_child[:3, 3]
    return message(
        TRANSFORM_TYPE,
        header=header(stamp_ns, parent),
        child_frame_id=child,
        transform=message(
            'geometry_msgs/msg/Transform',
            translation=message(
                'geometry_msgs/msg/Vector3',
                x=float(shift[0]),
                y=float(shift[1]),
                z=float(shift[2]),
            ),
            rotation=message('geometry_msgs/msg/Quaternion', x=x, y=y, z=z, w=w),
        ),
    )


def matrix_of(transform_stamped: Any) -> FloatArray:
    """Return parent_from_child of a geometry_msgs/TransformStamped, shape (4, 4).

    Raises:
        ValueError: when it holds no rotation, or is not finite.
    """
    move = transform_stamped.transform
    turn = move.rotation
    matrix = transform(
        rotation_from_quaternion(np.array([turn.x, turn.y, turn.z, turn.w])),
        np.array([move.translation.x, move.translation.y, move.translation.z]),
    )
    if not np.isfinite(matrix).all():
        raise ValueError('the transform holds NaN or Inf')
    return matrix
