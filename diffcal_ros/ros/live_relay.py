# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pass live camera topics on when they are sound, and count those that are not."""

from collections.abc import Callable, Mapping
from typing import Any

from diffcal_ros.errors import RecordingError
from diffcal_ros.live.frames.frame_gate import FrameGate
from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.inputs import transform_cure
from diffcal_ros.live.replay.replay_messages import Role
from diffcal_ros.live.stream_meter import Recent, StreamMeter
from diffcal_ros.observing.pose_sources import is_same_frame
from diffcal_ros.recording.topics.compressed_depth import decode_compressed_depth, encoding_of
from diffcal_ros.recording.topics.names import COMPRESSED_DEPTH
from diffcal_ros.ros.adaptive_subscription import AdaptiveSubscription
from diffcal_ros.ros.conversion import image_facts, image_message, stamp_ns
from diffcal_ros.ros.frame_tree import FrameTree
import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

FloatArray = NDArray[np.float64]

_IMAGES = ((Role.DEPTH, Role.DEPTH_INFO), (Role.COLOR, Role.COLOR_INFO))


class LiveRelay:
    """Listens to `in/...` and sends what is good."""

    def __init__(
        self,
        node: Node,
        senders: Mapping[Role, Any],
        send_transform: Callable[..., None],
        depth_from_color: FloatArray | None,
    ) -> None:
        """Start to listen.

        Args:
            node: whose topics they are.
            senders: publisher of each role.
            send_transform: sends where the colour camera is.
            depth_from_color: where that is, shape (4, 4), or None to look for it in TF.
        """
        self._node = node
        self._senders = senders
        self._send_transform = send_transform
        self._depth_from_color = depth_from_color
        self._has_sent = False
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._tree = FrameTree(node)
        self._frames: dict[Role, str] = {}
        self._meters = {image: StreamMeter() for image, _ in _IMAGES}
        self._gates = {
            image: FrameGate(image.value, is_depth=image is Role.DEPTH) for image, _ in _IMAGES
        }
        self._checked = {image: _Checked() for image, _ in _IMAGES}
        self._packed: AdaptiveSubscription | None = None
        self._listeners = [
            subscription
            for image, info in _IMAGES
            for subscription in (self._listen_to_image(image), self._listen_to_info(image, info))
        ]

    def destroy(self) -> None:
        """Stop listening."""
        for subscription in self._listeners:
            subscription.destroy()
        if self._packed is not None:
            self._packed.destroy()

    def health(self) -> dict[str, Health]:
        """Return how each stream of images is; sends the transform once it is known."""
        self._report_transform()
        self._look_for_packed()
        parts = {
            'live depth': self._stream_health(Role.DEPTH, is_needed=True),
            'live colour': self._stream_health(Role.COLOR, is_needed=False),
        }
        depth, color = self._frames.get(Role.DEPTH), self._frames.get(Role.COLOR)
        if depth is not None and color is not None and not self._has_sent:
            cure = transform_cure(color, depth, has_tf=self._tree.is_there)
            parts['cameras'] = Health(Level.WARN, f'not known: {cure}')
        elif self._has_sent:
            parts['cameras'] = Health(Level.OK, f'known: where {color!r} is in {depth!r}')
        return parts

    def _listen_to_image(self, role: Role) -> AdaptiveSubscription:
        return AdaptiveSubscription(
            self._node,
            Image,
            f'in/{role.value}',
            lambda image, info: self._pass_on(role, image),
            on_lost=lambda count: self._meters[role].lose(self._now_ns(), count),
        )

    def _now_ns(self) -> int:
        return int(self._steady.now().nanoseconds)

    def _pass_on(self, role: Role, image: Image) -> None:
        """Check an image, count it, and send it when it is good."""
        facts, now = image_facts(image), self._now_ns()
        self._meters[role].arrived(now, facts.stamp_ns)
        problem = self._gates[role].check(facts)
        self._checked[role].add(now, problem)
        if problem is None:
            self._frames[role] = facts.frame_id
            self._senders[role].publish(image)

    def _look_for_packed(self) -> None:
        """Listen to compressed depth while nobody publishes it as it is."""
        plain = self._listeners[0].topic
        topic = f'{plain}{COMPRESSED_DEPTH}'
        has_plain, has_packed = (self._node.count_publishers(name) > 0 for name in (plain, topic))
        is_wanted = has_packed and not has_plain
        if is_wanted and self._packed is None:
            self._node.get_logger().info(f'depth is read from {topic}')
            self._packed = AdaptiveSubscription(
                self._node,
                CompressedImage,
                topic,
                self._unpack,
                on_lost=lambda count: self._meters[Role.DEPTH].lose(self._now_ns(), count),
            )
        elif not is_wanted and self._packed is not None:
            self._packed.destroy()
            self._packed = None

    def _unpack(self, packed: CompressedImage, info: dict[str, int]) -> None:
        time_ns = stamp_ns(packed.header.stamp)
        try:
            pixels = decode_compressed_depth(packed.data, packed.format)
        except RecordingError as error:
            self._meters[Role.DEPTH].arrived(self._now_ns(), time_ns)
            self._checked[Role.DEPTH].add(self._now_ns(), str(error))
            return
        image = image_message(
            pixels,
            encoding=encoding_of(pixels),
            time_ns=time_ns,
            frame_id=packed.header.frame_id,
        )
        self._pass_on(Role.DEPTH, image)

    def _listen_to_info(self, image: Role, role: Role) -> AdaptiveSubscription:
        def on_info(message: CameraInfo, info: dict[str, int]) -> None:
            self._gates[image].camera_size = (message.width, message.height)
            self._senders[role].publish(message)

        return AdaptiveSubscription(self._node, CameraInfo, f'in/{role.value}', on_info)

    def _stream_health(self, role: Role, *, is_needed: bool) -> Health:
        gate, meter = self._gates[role], self._meters[role]
        now = self._steady.now().nanoseconds
        values = meter.figures(now, self._node.get_clock().now().nanoseconds)
        values['passed on'] = str(gate.passed)
        values.update({f'bad: {reason}': str(count) for reason, count in gate.bad.items()})
        topic = self._node.resolve_topic_name(f'in/{role.value}')
        if not meter.received:
            level = Level.WARN if is_needed else Level.OK
            return Health(level, f'waiting for images on {topic}', values)
        trouble = meter.trouble(now, f'images on {topic}') or self._checked[role].trouble(
            now, topic
        )
        if trouble is not None:
            return Health(*trouble, values)
        return Health(Level.OK, f'{values["input rate [Hz]"]} images a second', values)

    def _report_transform(self) -> None:
        depth, color = self._frames.get(Role.DEPTH), self._frames.get(Role.COLOR)
        if self._has_sent or depth is None or color is None:
            return
        found = self._depth_from_color
        if found is None and is_same_frame(depth, color):
            found = np.eye(4)
        if found is None:
            found = self._tree.find(depth, color)
        if found is not None:
            now = self._node.get_clock().now().nanoseconds
            self._send_transform(found, depth_frame=depth, color_frame=color, time_ns=now)
            self._has_sent = True


class _Checked:
    """What the checks of one topic's images said lately."""

    def __init__(self) -> None:
        self._good, self._bad, self._last = Recent(), Recent(), ''

    def add(self, now_ns: int, problem: str | None) -> None:
        """Note an image and what is wrong with it."""
        if problem is None:
            self._good.add(now_ns)
        else:
            self._bad.add(now_ns)
            self._last = problem

    def trouble(self, now_ns: int, topic: str) -> tuple[Level, str] | None:
        """Say what is wrong with the images of the last seconds, or None."""
        bad = self._bad.count(now_ns)
        if not bad:
            return None
        level = Level.WARN if self._good.count(now_ns) else Level.ERROR
        return level, f'{bad} bad images on {topic} within 10 s, the last: {self._last}'
