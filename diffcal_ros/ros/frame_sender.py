# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Transforms to TF, of frames that nobody else tells of."""

from collections import deque
from collections.abc import Iterable, Sequence
import threading
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.ros.conversion import header_message, transform_matrix, transform_message
from geometry_msgs.msg import TransformStamped
import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import deserialize_message

FloatArray = NDArray[np.float64]

TF, TF_STATIC = '/tf', '/tf_static'
# As tf2 sends and listens: one message holds all that a node says of what does not change.
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_HEARD = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_QUEUE = 100
# Transforms of the first second that are sent when it is over: ten frames at 100 Hz.
_KEPT = 1000
# So long it listens at least before it says anything, to learn what others tell [s].
_LISTENS = 1.0


class FrameSender:
    """Sends transforms, unless another node tells of their child frames already.

    A frame has one parent in TF: two nodes that tell of it make it jump. What others send on /tf
    is listened to until the first transform of this node goes out, for a second at least: a
    robot's /tf is too much to be read for ever.
    """

    def __init__(self, node: Node) -> None:
        """Start to listen; without tf2_msgs nothing is sent, which is logged."""
        self._node = node
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._begun_ns = self._steady.now().nanoseconds
        self._heard: dict[str, str] = {}
        self._own: set[str] = set()
        self._refused: set[str] = set()
        self._still: dict[str, TransformStamped] = {}
        self._waiting: dict[str, TransformStamped] = {}
        self._early: deque[TransformStamped] = deque(maxlen=_KEPT)
        # A replay sends from its own thread.
        self._lock = threading.RLock()
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            node.get_logger().info(
                'no frames are sent to TF: tf2_msgs is not installed (ros-jazzy-tf2-msgs)'
            )
            self._kind: Any = None
            return
        self._kind = TFMessage
        self._moving = node.create_publisher(TFMessage, TF, _QUEUE)
        self._latched = node.create_publisher(TFMessage, TF_STATIC, _LATCHED)
        self._listeners = [
            node.create_subscription(TFMessage, TF_STATIC, self._on_heard, _HEARD),
            node.create_subscription(TFMessage, TF, self._on_heard, _QUEUE),
        ]
        self._timer = node.create_timer(_LISTENS, self._look_after, clock=self._steady)

    def send(self, time_ns: int, parent: str, child: str, parent_from_child: FloatArray) -> None:
        """Send where a frame is at a time [ns]; one without a name is left out."""
        self._send_moving([_stamped(time_ns, parent, child, parent_from_child)])

    def pass_on(self, message: bytes) -> None:
        """Send what a recorded TFMessage, serialised, has of frames that nobody else tells of."""
        if self._kind is not None:
            stamped = deserialize_message(message, self._kind).transforms
            self._send_moving([one for one in stamped if _is_usable(one)])

    def send_still(self, time_ns: int, transforms: Iterable[tuple[str, str, FloatArray]]) -> None:
        """Send what does not change: parent, child and parent_from_child (4, 4) of each."""
        with self._lock:
            for parent, child, matrix in transforms:
                self._waiting[child] = _stamped(time_ns, parent, child, matrix)
            self._send_waiting()

    def destroy(self) -> None:
        """End the publishers."""
        if self._kind is not None:
            for listener in self._listeners:
                self._node.destroy_subscription(listener)
            self._node.destroy_publisher(self._moving)
            self._node.destroy_publisher(self._latched)
            self._node.destroy_timer(self._timer)
            self._kind = None

    def _send_moving(self, transforms: Sequence[TransformStamped]) -> None:
        with self._lock:
            self._early.extend(transforms)
            if self._is_early() or not self._early:
                return
            sent = [
                one
                for one in self._early
                if self._may_send(one.header.frame_id, one.child_frame_id)
            ]
            self._early.clear()
            if sent and self._node.context.ok():
                self._moving.publish(self._kind(transforms=sent))

    def _look_after(self) -> None:
        self._send_waiting()
        self._send_moving(())
        with self._lock:
            if self._own and len(self._listeners) > 1:
                self._node.destroy_subscription(self._listeners.pop())

    def _send_waiting(self) -> None:
        with self._lock:
            if self._kind is None or not self._waiting or self._is_early():
                return
            waiting, self._waiting = self._waiting, {}
            for child, stamped in waiting.items():
                if self._may_send(stamped.header.frame_id, child):
                    self._still[child] = stamped
            if self._still and self._node.context.ok():
                self._latched.publish(self._kind(transforms=list(self._still.values())))

    def _is_early(self) -> bool:
        return bool(self._steady.now().nanoseconds - self._begun_ns < _LISTENS * 1e9)

    def _may_send(self, parent: str, child: str) -> bool:
        if self._kind is None or not parent or not child or parent == child:
            return False
        if child in self._own:
            return True
        reason = self._known_elsewhere(parent, child)
        if reason:
            if child not in self._refused:
                self._refused.add(child)
                self._node.get_logger().info(f'the frame {child!r} is not sent to TF: {reason}')
            return False
        self._own.add(child)
        return True

    def _known_elsewhere(self, parent: str, child: str) -> str:
        """Say why a frame must have no other parent; empty where it may."""
        if child in self._heard:
            return f'another node says where it is, in {self._heard[child]!r}'
        ancestor, passed = parent, {parent}
        while ancestor in self._heard:
            ancestor = self._heard[ancestor]
            if ancestor == child:
                return f'other nodes say where {parent!r} is in it'
            if ancestor in passed:
                break
            passed.add(ancestor)
        return ''

    def _on_heard(self, message: Any) -> None:
        with self._lock:
            for stamped in message.transforms:
                if stamped.child_frame_id not in self._own:
                    self._heard[stamped.child_frame_id] = stamped.header.frame_id


def check_frame_names(*names: str) -> None:
    """Look whether frames may be called so in TF; an empty name is one that is not sent.

    Raises:
        InputError: when tf2 would refuse a name, or two frames have the same.
    """
    given = [name for name in names if name]
    for name in given:
        if name.startswith('/') or name != name.strip():
            raise InputError(
                f'{name!r} is no name of a frame: leave out the / or spaces around it'
            )
    if len(set(given)) < len(given):
        raise InputError(f'two frames are called {given[0]!r}: give each a name of its own')


def _is_usable(stamped: TransformStamped) -> bool:
    """Tell whether there is a rotation in it: every listener would complain of another."""
    try:
        transform_matrix(stamped.transform)
    except ValueError:
        return False
    return True


def _stamped(
    time_ns: int, parent: str, child: str, parent_from_child: FloatArray
) -> TransformStamped:
    return TransformStamped(
        header=header_message(time_ns, parent.lstrip('/')),
        child_frame_id=child.lstrip('/'),
        transform=transform_message(parent_from_child),
    )
