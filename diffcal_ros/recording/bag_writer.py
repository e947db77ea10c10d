# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write a rosbag2 directory (mcap) that `ros2 bag play` replays."""

from collections import Counter
from contextlib import suppress
import errno
import os
from pathlib import Path
import shutil
from types import TracebackType
from typing import Any, BinaryIO

from diffcal_ros import __version__
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.leftovers import fresh_path, remove_leftovers
from diffcal_ros.recording.bag.bag_metadata import (
    as_yaml,
    bag_metadata,
    BagTopic,
    qos_profiles,
)
from diffcal_ros.recording.topics.color_frame import ColorFrame
from diffcal_ros.recording.topics.names import (
    COLOR_CAMERA_INFO,
    COLOR_IMAGE,
    DEPTH_CAMERA_INFO,
    DEPTH_FROM_COLOR,
    DEPTH_IMAGE,
    TF_STATIC,
    TF_TYPE,
)
from diffcal_ros.recording.topics.ros_messages import (
    camera_info_message,
    definition,
    image_message,
    message,
    serialize,
    transform_message,
    type_hash,
)
from mcap.writer import CompressionType, Writer
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_COMPRESSIONS = {
    'zstd': CompressionType.ZSTD,
    'lz4': CompressionType.LZ4,
    'none': CompressionType.NONE,
}
_LATCHED_TYPES = (TF_STATIC, DEPTH_FROM_COLOR)


class BagWriter:
    """Writes one bag; use it in a `with` block.

    Everything goes to a hidden folder beside the target, which takes the target's name when the
    block ends without an error. Chunks, data and summary carry checksums.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        *,
        compression: str = 'zstd',
        overwrite: bool = False,
    ) -> None:
        """Name the bag.

        Args:
            path: directory to make.
            compression: of the chunks; zstd, lz4 or none.
            overwrite: replace a bag of that name.

        Raises:
            RecordingError: when the path exists already.
        """
        if compression not in _COMPRESSIONS:
            raise RecordingError(
                f'bag compression is {compression!r}: {", ".join(_COMPRESSIONS)} are written'
            )
        self.path = Path(path)
        self._fresh = fresh_path(self.path)
        self._overwrite = overwrite
        self._check_target()
        self._compression = _COMPRESSIONS[compression]
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._topics: dict[str, BagTopic] = {}
        self._counts: Counter[str] = Counter()
        self._stamps: tuple[int, int] | None = None

    def __enter__(self) -> 'BagWriter':
        try:
            self._fresh.mkdir(parents=True)
            remove_leftovers(self.path)
            self._stream: BinaryIO = (self._fresh / self._file_name).open('wb')
            self._writer = Writer(
                self._stream,
                compression=self._compression,
                enable_crcs=True,
                enable_data_crcs=True,
            )
            self._writer.start(profile='ros2', library=f'diffcal_ros {__version__}')
        except OSError as error:
            shutil.rmtree(self._fresh, ignore_errors=True)
            raise self._not_written(error) from error
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if kind is None:
                self._finish()
        except OSError as fault:
            raise self._not_written(fault) from fault
        finally:
            self._close_quietly()
            shutil.rmtree(self._fresh, ignore_errors=True)

    def write_depth(self, frame: DepthFrame, *, encoding: str = '32FC1') -> None:
        """Write a depth image, metres as 32FC1 or whole millimetres as 16UC1 (0 invalid)."""
        if encoding == '32FC1':
            pixels: NDArray[Any] = frame.depth.astype(np.float32)
        elif encoding == '16UC1':
            millimetres = np.rint(np.nan_to_num(frame.depth, nan=0.0, posinf=0.0) * 1000.0)
            pixels = np.where(millimetres <= 65535.0, millimetres, 0.0).astype(np.uint16)
        else:
            raise RecordingError(f'depth encoding is {encoding!r}: 32FC1 or 16UC1 are written')
        self.write(
            DEPTH_IMAGE,
            image_message(
                pixels, encoding=encoding, stamp_ns=frame.stamp_ns, frame_id=frame.frame_id
            ),
            frame.stamp_ns,
        )

    def write_color(self, frame: ColorFrame) -> None:
        """Write a colour image as bgr8."""
        self.write(
            COLOR_IMAGE,
            image_message(
                frame.image, encoding='bgr8', stamp_ns=frame.stamp_ns, frame_id=frame.frame_id
            ),
            frame.stamp_ns,
        )

    def write_depth_camera(self, camera: PinholeCamera, *, stamp_ns: int, frame_id: str) -> None:
        """Write the depth camera's camera_info."""
        info = camera_info_message(camera, stamp_ns=stamp_ns, frame_id=frame_id)
        self.write(DEPTH_CAMERA_INFO, info, stamp_ns)

    def write_color_camera(self, camera: PinholeCamera, *, stamp_ns: int, frame_id: str) -> None:
        """Write the colour camera's camera_info."""
        info = camera_info_message(camera, stamp_ns=stamp_ns, frame_id=frame_id)
        self.write(COLOR_CAMERA_INFO, info, stamp_ns)

    def write_depth_from_color(
        self, depth_from_color: FloatArray, *, depth_frame: str, color_frame: str, stamp_ns: int
    ) -> None:
        """Write where the colour camera is, as /tf_static and as a latched topic of its own."""
        stamped = transform_message(
            depth_from_color, parent=depth_frame, child=color_frame, stamp_ns=stamp_ns
        )
        self.write(TF_STATIC, message(TF_TYPE, transforms=[stamped]), stamp_ns)
        self.write(DEPTH_FROM_COLOR, stamped, stamp_ns)

    def write(self, topic: str, msg: Any, stamp_ns: int) -> None:
        """Write any message.

        Args:
            topic: absolute name; one type per topic.
            msg: made by `ros_messages.message`.
            stamp_ns: log time [ns].

        Raises:
            RecordingError: when the disk is full.
        """
        type_name = str(msg.__msgtype__)
        try:
            if topic not in self._channels:
                self._add_topic(topic, type_name)
            if self._topics[topic].type_name != type_name:
                raise ValueError(
                    f'{topic} carries {self._topics[topic].type_name}, not {type_name}'
                )
            self._writer.add_message(
                channel_id=self._channels[topic],
                log_time=stamp_ns,
                publish_time=stamp_ns,
                sequence=self._counts[topic],
                data=serialize(msg),
            )
        except OSError as error:
            raise self._not_written(error) from error
        self._counts[topic] += 1
        first, last = self._stamps or (stamp_ns, stamp_ns)
        self._stamps = (min(first, stamp_ns), max(last, stamp_ns))

    @property
    def _file_name(self) -> str:
        return f'{self.path.name}_0.mcap'

    def _add_topic(self, name: str, type_name: str) -> None:
        topic = BagTopic(name, type_name, type_hash(type_name), name in _LATCHED_TYPES)
        if type_name not in self._schemas:
            self._schemas[type_name] = self._writer.register_schema(
                type_name, 'ros2msg', definition(type_name).encode()
            )
        self._channels[name] = self._writer.register_channel(
            name,
            'cdr',
            self._schemas[type_name],
            {
                'offered_qos_profiles': as_yaml(qos_profiles(topic)),
                'topic_type_hash': topic.type_hash,
            },
        )
        self._topics[name] = topic

    def _finish(self) -> None:
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._stream.flush()
        os.fsync(self._stream.fileno())
        self._stream.close()
        first, last = self._stamps or (0, 0)
        text = bag_metadata(
            file_name=self._file_name,
            counts={self._topics[name]: count for name, count in self._counts.items()},
            first_ns=first,
            last_ns=last,
        )
        (self._fresh / 'metadata.yaml').write_text(text, encoding='utf-8')
        self._check_target()
        if self.path.exists():
            shutil.rmtree(self.path)
        self._fresh.rename(self.path)

    def _check_target(self) -> None:
        """Refuse to write over something that is there, and never over what is no bag."""
        if not self.path.exists():
            return
        if not self._overwrite:
            raise RecordingError(
                f'{self.path} exists already: remove it, choose another place, or ask for it to '
                'be overwritten'
            )
        is_bag = self.path.is_dir() and any(self.path.glob('*.mcap'))
        if not is_bag:
            raise RecordingError(f'{self.path} is no bag and is not overwritten: remove it')

    def _close_quietly(self) -> None:
        # What is buffered may find no room; the file goes away anyway.
        with suppress(OSError):
            self._stream.close()

    def _not_written(self, error: OSError) -> RecordingError:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            return RecordingError(
                f'{self.path} cannot be written: the disk is full ({error.strerror}); make room '
                'there or choose another place. Nothing was left behind'
            )
        return RecordingError(
            f'{self.path} cannot be written ({error.strerror or error}): choose a place that '
            'you may write to'
        )
