# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write depth images as a rosbag2 recording."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer
import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import get_typestore, Stores
from rosbags.typesys.store import Typestore

from benchmarks.blind.renderer import Camera

_FIRST_STAMP = 1_700_000_000_000_000_000  # [ns]
_PERIOD = 33_333_333  # [ns]
_FRAME = 'depth_optical_frame'
_IMAGE = ('/depth/image_rect_raw', 'sensor_msgs/msg/Image')
_INFO = ('/depth/camera_info', 'sensor_msgs/msg/CameraInfo')


@cache
def _types() -> Typestore:
    return get_typestore(Stores.ROS2_JAZZY)


def write_bag(
    path: Path,
    camera: Camera,
    frames: Sequence[NDArray[np.float32]],
    stamps: Sequence[int] | None = None,
) -> None:
    """Write one recording.

    Args:
        path: folder to make.
        camera: its intrinsics.
        frames: depth [m], shape (H, W), NaN where invalid.
        stamps: of the frames, after the first one [ns]; None: a thirtieth of a second apart.
    """
    if stamps is None:
        stamps = [number * _PERIOD for number in range(len(frames))]
    path.mkdir(parents=True)
    with (path / 'bag_0.mcap').open('wb') as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(profile='ros2', library='blind tests')
        channels = {topic: _channel(writer, topic, kind) for topic, kind in (_IMAGE, _INFO)}
        for number, (depth, after) in enumerate(zip(frames, stamps, strict=True)):
            stamp = _FIRST_STAMP + after
            for topic, message in (
                (_INFO[0], _camera_info(camera, stamp)),
                (_IMAGE[0], _image(depth, stamp)),
            ):
                data = bytes(_types().serialize_cdr(message, message.__msgtype__))
                writer.add_message(channels[topic], stamp, data, stamp, number)
        writer.finish()  # type: ignore[no-untyped-call]
    (path / 'metadata.yaml').write_text(_metadata(len(frames), stamps[-1]))


def _channel(writer: Writer, topic: str, kind: str) -> int:
    text, _ = _types().generate_msgdef(kind, ros_version=2)
    schema = writer.register_schema(kind, 'ros2msg', text.encode())
    return writer.register_channel(topic, 'cdr', schema, {'offered_qos_profiles': ''})


def _header(stamp: int) -> Any:
    types = _types().types
    time = types['builtin_interfaces/msg/Time'](
        sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000
    )
    return types['std_msgs/msg/Header'](stamp=time, frame_id=_FRAME)


def _image(depth: NDArray[np.float32], stamp: int) -> Any:
    return _types().types[_IMAGE[1]](
        header=_header(stamp),
        height=depth.shape[0],
        width=depth.shape[1],
        encoding='32FC1',
        is_bigendian=0,
        step=4 * depth.shape[1],
        data=np.frombuffer(depth.astype('<f4').tobytes(), dtype=np.uint8),
    )


def _camera_info(camera: Camera, stamp: int) -> Any:
    types = _types().types
    K = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    region = types['sensor_msgs/msg/RegionOfInterest'](
        x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    return types[_INFO[1]](
        header=_header(stamp),
        height=camera.height,
        width=camera.width,
        distortion_model='plumb_bob',
        d=np.zeros(5),
        k=K.ravel(),
        r=np.eye(3).ravel(),
        p=np.hstack([K, np.zeros((3, 1))]).ravel(),
        binning_x=0,
        binning_y=0,
        roi=region,
    )


def _metadata(count: int, duration: int) -> str:
    topics = ''.join(
        f"""
    - topic_metadata:
        name: {topic}
        type: {kind}
        serialization_format: cdr
        offered_qos_profiles: []
        type_description_hash: ''
      message_count: {count}"""
        for topic, kind in (_INFO, _IMAGE)
    )
    return f"""rosbag2_bagfile_information:
  version: 9
  storage_identifier: mcap
  duration:
    nanoseconds: {duration}
  starting_time:
    nanoseconds_since_epoch: {_FIRST_STAMP}
  message_count: {2 * count}
  topics_with_message_count:{topics}
  compression_format: ''
  compression_mode: ''
  relative_file_paths:
    - bag_0.mcap
  files:
    - path: bag_0.mcap
      starting_time:
        nanoseconds_since_epoch: {_FIRST_STAMP}
      duration:
        nanoseconds: {duration}
      message_count: {2 * count}
  custom_data: ~
  ros_distro: jazzy
"""
