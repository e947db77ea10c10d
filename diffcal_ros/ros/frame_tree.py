# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""TF, where it is installed: tf2 is imported only when somebody asks for it."""

from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.recording.frame_tree import TOLERANCE_NS
from diffcal_ros.ros.conversion import transform_matrix, transform_message
from geometry_msgs.msg import TransformStamped
import numpy as np
from numpy.typing import NDArray
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time

FloatArray = NDArray[np.float64]

# For as long as a window of frames may take, or a swing [s].
_REMEMBERED = 60


class FrameTree:
    """Listens to TF; without tf2 it knows nothing."""

    def __init__(self, node: Node) -> None:
        self._buffer: Any = None
        try:
            from tf2_ros import Buffer, TransformListener
        except ImportError:
            return
        self._buffer = Buffer(cache_time=Duration(seconds=_REMEMBERED))
        self._listener = TransformListener(self._buffer, node)

    @property
    def is_there(self) -> bool:
        """Tell whether tf2 is installed."""
        return self._buffer is not None

    def find(self, target: str, source: str, stamp_ns: int | None = None) -> FloatArray | None:
        """Return target_from_source, shape (4, 4), or None when it is not known.

        Args:
            target: frame name.
            source: frame name.
            stamp_ns: when [ns]; where TF has not got there yet, the newest within a tolerance is
                taken. None: the newest.
        """
        if self._buffer is None:
            return None
        names = target.lstrip('/'), source.lstrip('/')
        when = Time() if stamp_ns is None else Time(nanoseconds=stamp_ns)
        if not self._buffer.can_transform(*names, when):
            newest = self._newest(*names)
            if stamp_ns is None or newest is None:
                return None
            if abs(newest.nanoseconds - stamp_ns) > TOLERANCE_NS:
                return None
            when = newest
        return transform_matrix(self._buffer.lookup_transform(*names, when).transform)

    def _newest(self, target: str, source: str) -> Time | None:
        """Return when all of a chain was known last, or None."""
        if not self._buffer.can_transform(target, source, Time()):
            return None
        found = self._buffer.lookup_transform(target, source, Time())
        return Time.from_msg(found.header.stamp, clock_type=Time().clock_type)


class FrameSender:
    """Sends transforms to TF."""

    def __init__(self, node: Node) -> None:
        """Start.

        Raises:
            InputError: when tf2 is not installed.
        """
        try:
            from tf2_ros import TransformBroadcaster
        except ImportError as error:
            raise InputError(
                'publish_tf needs the package tf2_ros, which is not installed: install '
                'ros-jazzy-tf2-ros, or leave publish_tf off and use the topic marker_pose/pose'
            ) from error
        self._broadcaster = TransformBroadcaster(node)

    def send(self, header: Any, child: str, parent_from_child: FloatArray) -> None:
        """Send one transform; the header says parent frame and time."""
        self._broadcaster.sendTransform(
            TransformStamped(
                header=header,
                child_frame_id=child,
                transform=transform_message(parent_from_child),
            )
        )
