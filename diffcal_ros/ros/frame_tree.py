# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""TF as a node hears it: through tf2 where that is installed, else from the topics themselves."""

from typing import Any, Protocol

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.topics.frame_tree import FrameTree as Transforms
from diffcal_ros.recording.topics.frame_tree import TOLERANCE_NS
from diffcal_ros.ros.conversion import stamp_ns as stamp_ns_of
from diffcal_ros.ros.conversion import transform_matrix
from geometry_msgs.msg import TransformStamped
import numpy as np
from numpy.typing import NDArray
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time

FloatArray = NDArray[np.float64]

# For as long as a window of frames may take, or a swing [s].
_REMEMBERED = 60
_SECOND = 1_000_000_000  # [ns]


class _Listener(Protocol):
    def find(self, target: str, source: str, stamp_ns: int | None) -> FloatArray | None:
        """Return target_from_source, shape (4, 4), or None when it is not known."""


class FrameTree:
    """Listens to TF; without its message type, which comes with tf2, it knows nothing."""

    def __init__(self, node: Node) -> None:
        self._listener = _listen(node)

    @property
    def is_there(self) -> bool:
        """Tell whether TF can be listened to."""
        return self._listener is not None

    def find(self, target: str, source: str, stamp_ns: int | None = None) -> FloatArray | None:
        """Return target_from_source, shape (4, 4), or None when it is not known.

        Args:
            target: frame name.
            source: frame name.
            stamp_ns: when [ns]; where TF has not got there yet, the newest within a tolerance is
                taken. None: the newest.
        """
        if self._listener is None:
            return None
        return self._listener.find(target.lstrip('/'), source.lstrip('/'), stamp_ns)


def _listen(node: Node) -> _Listener | None:
    try:
        return _Tf2(node)
    except ImportError:
        pass
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        return None
    heard = HeardFrames()
    latched = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(TFMessage, '/tf', heard.take, 100)
    node.create_subscription(TFMessage, '/tf_static', heard.take_static, latched)
    return heard


class _Tf2:
    """What tf2 knows."""

    def __init__(self, node: Node) -> None:
        from tf2_ros import Buffer, TransformListener

        self._buffer: Any = Buffer(cache_time=Duration(seconds=_REMEMBERED))
        self._listener = TransformListener(self._buffer, node)

    def find(self, target: str, source: str, stamp_ns: int | None) -> FloatArray | None:
        when = Time() if stamp_ns is None else Time(nanoseconds=stamp_ns)
        if not self._buffer.can_transform(target, source, when):
            newest = self._newest(target, source)
            if stamp_ns is None or newest is None:
                return None
            if abs(newest.nanoseconds - stamp_ns) > TOLERANCE_NS:
                return None
            when = newest
        return transform_matrix(self._buffer.lookup_transform(target, source, when).transform)

    def _newest(self, target: str, source: str) -> Time | None:
        """Return when all of a chain was known last, or None."""
        if not self._buffer.can_transform(target, source, Time()):
            return None
        found = self._buffer.lookup_transform(target, source, Time())
        return Time.from_msg(found.header.stamp, clock_type=Time().clock_type)


class HeardFrames:
    """What came on /tf_static, and on /tf within the last minute or two."""

    def __init__(self) -> None:
        self._static: dict[str, TransformStamped] = {}
        # The older one is dropped, with all that it remembers, when the newer one is a minute old.
        self._newer, self._older = Transforms(), Transforms()
        self._begun_ns: int | None = None

    def take(self, message: Any) -> None:
        """Take in a message of /tf."""
        for stamped in message.transforms:
            now = stamp_ns_of(stamped.header.stamp)
            begun = now if self._begun_ns is None else self._begun_ns
            if not begun <= now <= begun + _REMEMBERED * _SECOND:
                self._newer, self._older = Transforms(), self._newer
                begun = now
                for still in self._static.values():
                    _add(self._newer, still, None)
            self._begun_ns = begun
            _add(self._newer, stamped, now)

    def take_static(self, message: Any) -> None:
        """Take in a message of /tf_static."""
        for stamped in message.transforms:
            self._static[stamped.child_frame_id] = stamped
            _add(self._newer, stamped, None)

    def find(self, target: str, source: str, stamp_ns: int | None) -> FloatArray | None:
        """Return target_from_source, shape (4, 4), or None when it is not known then."""
        for tree in (self._newer, self._older):
            try:
                found = tree.find(target, source, stamp_ns)
            except RecordingError:  # Not known at that time, or unusable.
                continue
            if found is not None:
                return found
        return None


def _add(tree: Transforms, stamped: TransformStamped, when_ns: int | None) -> None:
    parent, child = stamped.header.frame_id, stamped.child_frame_id
    try:
        tree.add(parent, child, transform_matrix(stamped.transform), stamp_ns=when_ns)
    except ValueError as error:
        tree.add(parent, child, None, problem=str(error))
