# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the calibration node publishes about a fit."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from diffcal_ros.calibration.results.result import FittedParameter
from diffcal_ros.calibration.tracking.body_change import BodyChange
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis
from diffcal_ros.live.frames.body_frames import BodyFrames
from diffcal_ros.live.picture import Picture
from diffcal_ros.live.tasks.fit_task import FitEnd, FitStep
from diffcal_ros.live.tasks.track_task import TrackStep
from diffcal_ros.live.tracking import Tracking
from diffcal_ros.ros.conversion import (
    camera_info_message,
    header_message,
    image_message,
)
from diffcal_ros.ros.estimate_messages import (
    change_message,
    covariance_message,
    estimates_message,
    topic_of,
    tracked_message,
)
from diffcal_ros.ros.frame_sender import FrameSender
from diffcal_ros.ros.qos import LATCHED, LATCHED_IMAGES
from diffcal_ros.ros.verdict_messages import verdict_message
from diffcal_ros.scene.model import Scene
from geometry_msgs.msg import Point
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import ColorRGBA, Float64, Float64MultiArray, Header
from visualization_msgs.msg import Marker

_SURFACE = ColorRGBA(r=0.20, g=0.55, b=0.85, a=0.8)


@dataclass(frozen=True)
class FrameNames:
    """What is sent to TF.

    Attributes:
        is_sent: anything at all.
        world: name of the scene's world; empty where TF says where it is.
        body: name of the mesh file's own frame.
    """

    is_sent: bool
    world: str
    body: str


class CalibrationOutputs:
    """Publishers of one calibration node; those of single parameters are made when needed."""

    def __init__(self, node: LifecycleNode, names: Callable[[], FrameNames]) -> None:
        """Make them.

        Args:
            node: whose topics they are.
            names: asked for the frames that are sent to TF.
        """
        self._node = node
        self._names = names
        self._frames = FrameSender(node) if names().is_sent else None
        self._rendered = self._publisher(Image, '~/rendered/image', LATCHED_IMAGES)
        self._rendered_info = self._publisher(CameraInfo, '~/rendered/camera_info', LATCHED_IMAGES)
        self._residual = self._publisher(Image, '~/residual', LATCHED_IMAGES)
        self._mesh = self._publisher(Marker, '~/mesh', LATCHED)
        self._estimates = self._publisher(DiagnosticArray, '~/estimates', LATCHED)
        self._covariance = self._publisher(Float64MultiArray, '~/covariance', LATCHED)
        self._change = self._publisher(DiagnosticArray, '~/change', LATCHED)
        self._verdict = self._publisher(DiagnosticArray, '~/verdict', LATCHED)
        self._numbers: dict[str, Any] = {}

    def publish_step(self, scene: Scene, step: FitStep) -> None:
        """Publish what is known after a step; standard errors are NaN until the end."""
        self._publish_parameters(step.parameters)
        self._estimates.publish(
            estimates_message(scene, step.parameters, step.record, None, _header(step.picture))
        )
        self.publish_picture(step.picture)

    def publish_end(self, scene: Scene, end: FitEnd) -> None:
        """Publish the result."""
        result = end.result
        self._publish_parameters(result.parameters)
        self._estimates.publish(
            estimates_message(
                scene, result.parameters, result.history[-1], result, _header(end.picture)
            )
        )
        self._covariance.publish(covariance_message(result.parameters, result.correlation))
        self._publish_frames(end.frames, end.picture.stamp_ns, end.picture.frame_id)
        self.publish_picture(end.picture)

    def publish_tracked(self, scene: Scene, tracking: Tracking, step: TrackStep) -> None:
        """Publish what is known after a frame."""
        tracked = step.tracked
        self._publish_parameters(tracked.parameters)
        self._estimates.publish(
            tracked_message(scene, step, tracking.change, tracking.change_count)
        )
        self._covariance.publish(covariance_message(tracked.parameters, tracked.correlation))
        self._publish_frames(step.frames, tracked.stamp_ns, step.frame_id)

    def publish_change(self, change: BodyChange, count: int, frame_id: str) -> None:
        """Publish a change of the body; the last one stays."""
        self._change.publish(change_message(change, count, frame_id))

    @property
    def has_onlookers(self) -> bool:
        """Tell whether somebody looks at pictures."""
        senders = (self._rendered, self._residual, self._mesh)
        return any(sender.get_subscription_count() for sender in senders)

    def publish_verdict(self, diagnosis: Diagnosis, time_ns: int, frame_id: str) -> None:
        """Publish a verdict."""
        self._verdict.publish(verdict_message(diagnosis, header_message(time_ns, frame_id)))

    def destroy(self) -> None:
        """End all publishers."""
        fixed = [self._rendered, self._rendered_info, self._residual, self._mesh]
        fixed += [self._estimates, self._covariance, self._change, self._verdict]
        if self._frames is not None:
            self._frames.destroy()
        for publisher in [*fixed, *self._numbers.values()]:
            self._node.destroy_lifecycle_publisher(publisher)

    def _publish_frames(self, frames: BodyFrames, time_ns: int, depth_frame: str) -> None:
        if self._frames is None:
            return
        names = self._names()
        self._frames.send(time_ns, depth_frame, names.world, frames.depth_from_world)
        self._frames.send(time_ns, depth_frame, names.body, frames.depth_from_object)

    def _publisher(self, msg_type: Any, topic: str, qos: QoSProfile) -> Any:
        return self._node.create_lifecycle_publisher(
            msg_type,
            topic,
            qos,
            qos_overriding_options=QoSOverridingOptions.with_default_policies(),
        )

    def _publish_parameters(self, parameters: tuple[FittedParameter, ...]) -> None:
        for parameter in parameters:
            if parameter.is_nuisance:
                continue
            for what in ('value', 'std_error'):
                topic = f'~/parameters/{topic_of(parameter.name)}/{what}'
                number = float(getattr(parameter, what))
                self._number_publisher(topic).publish(Float64(data=number))

    def _number_publisher(self, topic: str) -> Any:
        if topic not in self._numbers:
            publisher = self._publisher(Float64, topic, LATCHED)
            # Made while the node is active: it missed the transition.
            publisher.on_activate(None)
            self._numbers[topic] = publisher
        return self._numbers[topic]

    def publish_picture(self, picture: Picture) -> None:
        """Publish what the model sees."""
        time_ns, frame_id = picture.stamp_ns, picture.frame_id
        info = camera_info_message(picture.camera, time_ns=time_ns, frame_id=frame_id)
        self._rendered_info.publish(info)
        for sender, image in (
            (self._rendered, picture.rendered),
            (self._residual, picture.residual),
        ):
            sender.publish(
                image_message(image, encoding='32FC1', time_ns=time_ns, frame_id=frame_id)
            )
        self._mesh.publish(mesh_message(picture))


def _header(picture: Picture) -> Header:
    return header_message(picture.stamp_ns, picture.frame_id)


def mesh_message(picture: Picture) -> Marker:
    """Return the deformed surface in the depth camera's frame."""
    marker = Marker(ns='body', id=0, type=Marker.TRIANGLE_LIST, action=Marker.ADD, color=_SURFACE)
    marker.header = _header(picture)
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    corners = [Point(x=x, y=y, z=z) for x, y, z in picture.points.tolist()]
    marker.points = [corners[corner] for corner in picture.triangles.ravel().tolist()]
    return marker
