# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A camera that films the small scene over DDS, and can be made to err in all the usual ways."""

import array
from collections.abc import Callable
import copy
from pathlib import Path
import time
from typing import Any

from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.ros.conversion import camera_info_message, image_message, stamp_message
import numpy as np
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image

DEPTH, COLOR = 'depth', 'color'
_TOPICS = {
    DEPTH: ('in/depth/image_rect_raw', 'in/depth/camera_info'),
    COLOR: ('in/color/image_raw', 'in/color/camera_info'),
}
_RATE = 10.0  # [Hz]
_RELIABLE = QoSProfile(depth=5)
_BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
Spoil = Callable[[Any], Any]


class Camera:
    """Publishes the frames of a recording again and again, with stamps of now.

    Attributes:
        spoil: changes an image before it is sent, by stream; None leaves one out.
        spoil_info: likewise a camera_info.
        shift_ns: of the camera's clock.
        depth_from_color: as the parameter of the depth source has it.
    """

    def __init__(self, node: Any, bag: Path) -> None:
        recording = open_recording(bag)
        depth, color = list(recording.depth_frames()), list(recording.color_frames())
        names = (recording.depth_frame_id, recording.color_frame_id)
        cameras = (recording.depth_camera, recording.color_camera)
        self.depth_from_color = recording.depth_from_color
        self._node = node
        self._images = {
            DEPTH: [_image(one.depth, '32FC1', names[0]) for one in depth],
            COLOR: [_image(one.image, 'bgr8', names[1]) for one in color],
        }
        self._infos = {
            stream: camera_info_message(camera, time_ns=0, frame_id=name)
            for stream, camera, name in zip((DEPTH, COLOR), cameras, names, strict=True)
        }
        self._senders: dict[str, tuple[Any, Any]] = {}
        self._count = 0
        self._next = time.monotonic()
        self.behave()
        self.restart()

    def behave(self) -> None:
        """Make no error from now on."""
        self.spoil: dict[str, Spoil] = {}
        self.spoil_info: dict[str, Spoil] = {}
        self.shift_ns = 0
        self.burst = 1

    def restart(self, *, is_best_effort: bool = False) -> None:
        """End the publishers, and make others."""
        for senders in self._senders.values():
            for sender in senders:
                self._node.destroy_publisher(sender)
        qos = _BEST_EFFORT if is_best_effort else _RELIABLE
        self._senders = {
            stream: (
                self._node.create_publisher(Image, topics[0], qos),
                self._node.create_publisher(CameraInfo, topics[1], qos),
            )
            for stream, topics in _TOPICS.items()
        }

    def film(self) -> None:
        """Send what is due."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = max(self._next + 1.0 / _RATE, now - 0.2)
        for _ in range(self.burst):
            self._send(DEPTH)
        if self._count % 5 == 0:
            self._send(COLOR)
        self._count += 1

    def _send(self, stream: str) -> None:
        stamp = stamp_message(time.time_ns() + self.shift_ns)
        images = self._images[stream]
        message = copy.copy(images[self._count % len(images)])
        message.header = copy.deepcopy(message.header)
        message.header.stamp = stamp
        info = copy.deepcopy(self._infos[stream])
        info.header.stamp = stamp
        info = self.spoil_info.get(stream, _as_it_is)(info)
        message = self.spoil.get(stream, _as_it_is)(message)
        image_sender, info_sender = self._senders[stream]
        if info is not None:
            info_sender.publish(info)
        if message is not None:
            image_sender.publish(message)


def _as_it_is(message: Any) -> Any:
    return message


def _image(pixels: np.ndarray, encoding: str, frame_id: str) -> Image:
    return image_message(pixels, encoding=encoding, time_ns=0, frame_id=frame_id)


def with_fields(**fields: Any) -> Spoil:
    """Return what sets fields of a message."""

    def change(message: Any) -> Any:
        for name, value in fields.items():
            setattr(message, name, value)
        return message

    return change


def with_header(**fields: Any) -> Spoil:
    """Return what sets fields of a message's header."""

    def change(message: Any) -> Any:
        for name, value in fields.items():
            setattr(message.header, name, value)
        return message

    return change


def with_pixels(change: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    """Return what changes the depths of an image [m]."""

    def spoilt(message: Any) -> Any:
        depth = np.frombuffer(message.data, '<f4').reshape(message.height, message.width)
        message.data = array.array('B', change(depth).astype('<f4').tobytes())
        return message

    return spoilt


def cut_off(message: Any) -> Any:
    """Keep half of an image's data."""
    message.data = message.data[: len(message.data) // 2]
    return message


def nothing(message: Any) -> None:
    """Leave a message out."""
