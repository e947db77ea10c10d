# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the calibration node subscribes to, handed on to the session."""

from collections.abc import Callable
from typing import Any

from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.inputs import (
    CameraTransform,
    DEPTH_TOPIC,
    POSE_TOPIC,
    SEEN_TOPIC,
    TRANSFORM_TOPIC,
)
from diffcal_ros.live.session import Session
from diffcal_ros.live.stream_meter import StreamMeter
from diffcal_ros.observing.pose_sources import ESTIMATED
from diffcal_ros.ros.adaptive_subscription import AdaptiveSubscription, noting
from diffcal_ros.ros.conversion import (
    depth_camera,
    depth_frame,
    pose_matrix,
    stamp_ns,
    transform_matrix,
)
from diffcal_ros.ros.frame_tree import FrameTree
from diffcal_ros.stamped_pose import known_covariance, StampedPose
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TransformStamped
import numpy as np
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Int32MultiArray

DEPTH, CAMERA_INFO, TRANSFORM = DEPTH_TOPIC, 'depth/camera_info', TRANSFORM_TOPIC
_PLAIN_POSE = 'geometry_msgs/msg/PoseStamped'
_NO_TF2 = (
    'a pose from TF needs the package tf2_ros, which is not installed: install '
    "ros-jazzy-tf2-ros, or use another source of the pose, such as 'topic'"
)
_QUIET = 5.0  # Without frames for so long something is wrong [s].


class CalibrationInputs:
    """The subscriptions of an active calibration node."""

    def __init__(self, node: Node, steady: Clock, session: Session) -> None:
        self._node = node
        self._steady = steady
        self._system = Clock(clock_type=ClockType.SYSTEM_TIME)
        self._session = session
        self._meter = StreamMeter()
        self._begun_ns = steady.now().nanoseconds
        self._last_ns = self._begun_ns
        self._tree = FrameTree(node)
        self._listeners = [
            self._subscribe_to_depth(),
            self._subscribe(CameraInfo, CAMERA_INFO, self._on_camera_info),
            self._subscribe(TransformStamped, TRANSFORM, self._on_transform, is_latched=True),
            self._subscribe(Int32MultiArray, SEEN_TOPIC, self._on_seen),
        ]
        self._poses: AdaptiveSubscription | None = None
        self._listened_to: tuple[str, Any] = ('', None)
        self._look_at_poses()

    def feed(self, session: Session) -> None:
        """Hand everything to another session from now on."""
        session.bad_inputs = self._session.bad_inputs
        session.inputs.take_over(self._session.inputs)
        self._session = session
        self._look_at_poses()

    def destroy(self) -> None:
        """End the subscriptions."""
        for subscription in self._listeners:
            subscription.destroy()
        if self._poses is not None:
            self._poses.destroy()

    def health(self) -> Health:
        """Return how the input stands; looks for the transform in TF where it is missing."""
        self._look_at_poses()
        self._look_into_tree()
        now = self._steady.now().nanoseconds
        values = self._meter.figures(now, self._node.get_clock().now().nanoseconds)
        newest = self._session.window.newest
        fraction = 'none yet' if newest is None else f'{newest.valid_fraction:.3f}'
        values['valid pixels [share]'] = fraction
        values['frames in the window'] = str(len(self._session.window.frames))
        trouble = self._meter.trouble(now, 'depth images')
        if trouble is not None:
            # A recording that has ended is no fault: what is wrong, the source knows.
            return Health(Level.WARN, trouble[1], values)
        quiet = (now - self._begun_ns) / 1e9
        if not self._meter.received and quiet > _QUIET:
            return Health(Level.WARN, f'no depth image has come for {quiet:.0f} s', values)
        return Health(Level.OK, f'{values["input rate [Hz]"]} depth images a second', values)

    def _subscribe(
        self, msg_type: Any, topic: str, callback: Callable[[Any], None], **options: Any
    ) -> AdaptiveSubscription:
        noted = noting(self._session.bad_inputs, topic, callback)
        return AdaptiveSubscription(self._node, msg_type, topic, noted, **options)

    def _subscribe_to_depth(self) -> AdaptiveSubscription:
        noted = noting(self._session.bad_inputs, DEPTH, self._on_depth)

        def counted(image: Image, info: dict[str, int]) -> None:
            self._count(image, info)
            noted(image, info)

        return AdaptiveSubscription(self._node, Image, DEPTH, counted, on_lost=self._on_lost)

    def _count(self, image: Image, info: dict[str, int]) -> None:
        self._last_ns = self._steady.now().nanoseconds
        published = info.get('source_timestamp') or 0
        delay = self._system.now().nanoseconds - published if published else None
        self._meter.arrived(self._last_ns, stamp_ns(image.header.stamp), delay)

    def _on_lost(self, count: int) -> None:
        self._meter.lose(self._steady.now().nanoseconds, count)

    def _on_depth(self, image: Image) -> None:
        restart = self._session.add_frame(depth_frame(image), self._last_ns)
        if restart is not None:
            self._node.get_logger().info(f'{restart}: the window starts anew')
        self._session.poll(self._last_ns)

    def _on_camera_info(self, info: CameraInfo) -> None:
        image_topic = self._listeners[0].topic
        changed = self._session.set_camera(depth_camera(info, CAMERA_INFO, image_topic))
        if changed is not None:
            self._node.get_logger().warning(changed)

    def _look_at_poses(self) -> None:
        """Listen to the topic that is asked for, with the type that its publishers have."""
        inputs = self._session.inputs
        inputs.lookup = self._tree.find if self._tree.is_there else None
        if inputs.source == 'tf' and inputs.lookup is None:
            self._session.bad_inputs['tf'] = _NO_TF2
        else:
            self._session.bad_inputs.pop('tf', None)
        wanted = (inputs.pose_topic, self._pose_kind(inputs.pose_topic))
        if wanted == self._listened_to:
            return
        self._session.bad_inputs.pop(self._listened_to[0], None)
        if self._poses is not None:
            self._poses.destroy()
        self._listened_to, (name, kind) = wanted, wanted
        # What is published once, as a calibration is, counts as well.
        is_latched = name != POSE_TOPIC
        self._poses = (
            None
            if kind is None
            else self._subscribe(kind, name, self._on_pose, is_latched=is_latched)
        )

    def _pose_kind(self, name: str) -> Any:
        """Return the type of a topic's poses; None while nobody publishes what may be either."""
        topic = self._node.resolve_topic_name(name)
        offered = {o.topic_type for o in self._node.get_publishers_info_by_topic(topic)}
        if offered == {_PLAIN_POSE}:
            return PoseStamped
        return PoseWithCovarianceStamped if offered or name == POSE_TOPIC else None

    def _on_pose(self, message: PoseStamped | PoseWithCovarianceStamped) -> None:
        is_plain = isinstance(message, PoseStamped)
        covariance = None if is_plain else known_covariance(np.array(message.pose.covariance))
        self._session.inputs.pose = StampedPose(
            frame_from_body=pose_matrix(message.pose if is_plain else message.pose.pose),
            covariance=covariance,
            frame_id=message.header.frame_id,
            stamp_ns=stamp_ns(message.header.stamp),
        )

    def _on_seen(self, message: Int32MultiArray) -> None:
        self._session.inputs.seen_ids = tuple(message.data)

    def _on_transform(self, message: TransformStamped) -> None:
        self._session.inputs.transform = CameraTransform(
            depth_from_color=transform_matrix(message.transform),
            depth_frame=message.header.frame_id,
            color_frame=message.child_frame_id,
        )

    def _look_into_tree(self) -> None:
        inputs, newest = self._session.inputs, self._session.window.newest
        if inputs.transform is not None or inputs.pose is None or newest is None:
            return
        # Of another pose than a marker's TF is asked frame by frame.
        is_asked = inputs.source == ESTIMATED and newest.frame_id and inputs.pose.frame_id
        if not is_asked:
            return
        found = self._tree.find(newest.frame_id, inputs.pose.frame_id)
        if found is not None:
            inputs.transform = CameraTransform(found, newest.frame_id, inputs.pose.frame_id)
