# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the calibration node subscribes to, handed on to the session."""

from collections.abc import Callable
from typing import Any

from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.inputs import CameraTransform, RigPoseMessage
from diffcal_ros.live.session import Session
from diffcal_ros.live.stream_meter import StreamMeter
from diffcal_ros.ros.adaptive_subscription import AdaptiveSubscription, noting
from diffcal_ros.ros.conversion import (
    depth_camera,
    depth_frame,
    pose_matrix,
    stamp_ns,
    transform_matrix,
)
from diffcal_ros.ros.frame_tree import FrameTree
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
import numpy as np
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image

DEPTH, CAMERA_INFO = 'depth/image_rect_raw', 'depth/camera_info'
POSE, TRANSFORM = 'marker_pose/pose', 'depth_from_color'
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
            self._subscribe(PoseWithCovarianceStamped, POSE, self._on_pose),
            self._subscribe(TransformStamped, TRANSFORM, self._on_transform, is_latched=True),
        ]

    def feed(self, session: Session) -> None:
        """Hand everything to another session from now on."""
        session.bad_inputs = self._session.bad_inputs
        session.inputs.pose = self._session.inputs.pose
        session.inputs.transform = self._session.inputs.transform
        self._session = session

    def destroy(self) -> None:
        """End the subscriptions."""
        for subscription in self._listeners:
            subscription.destroy()

    def health(self) -> Health:
        """Return how the input stands; looks for the transform in TF where it is missing."""
        self._look_into_tree()
        now = self._steady.now().nanoseconds
        values = self._meter.figures(now, self._node.get_clock().now().nanoseconds)
        newest = self._session.window.newest
        share = 'none yet' if newest is None else f'{newest.valid_fraction:.3f}'
        values['valid pixels [share]'] = share
        values['frames in the window'] = str(len(self._session.window.frames))
        quiet = (now - self._last_ns) / 1e9
        if quiet > _QUIET:
            return Health(Level.WARN, f'no depth image for {quiet:.0f} s', values)
        if self._meter.lost:
            return Health(Level.WARN, f'{self._meter.lost} depth images were lost', values)
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
        self._meter.lost += count

    def _on_depth(self, image: Image) -> None:
        restart = self._session.add_frame(depth_frame(image), self._last_ns)
        if restart is not None:
            self._node.get_logger().info(f'{restart}: the window starts anew')
        self._session.poll(self._last_ns)

    def _on_camera_info(self, info: CameraInfo) -> None:
        image_topic = self._listeners[0].topic
        self._session.inputs.set_camera(depth_camera(info, CAMERA_INFO, image_topic))

    def _on_pose(self, message: PoseWithCovarianceStamped) -> None:
        covariance = np.array(message.pose.covariance, dtype=np.float64).reshape(6, 6)
        if not np.isfinite(covariance).all():
            raise ValueError('the covariance holds NaN or Inf: publish zeros where it is unknown')
        # By ROS's convention zeros mean that it is not known.
        self._session.inputs.pose = RigPoseMessage(
            camera_from_rig=pose_matrix(message.pose.pose),
            covariance=covariance if np.diag(covariance).min() > 0.0 else None,
            frame_id=message.header.frame_id,
        )

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
        found = self._tree.find(newest.frame_id, inputs.pose.frame_id)
        if found is not None:
            inputs.transform = CameraTransform(found, newest.frame_id, inputs.pose.frame_id)
