# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The marker pose node: colour images in, the pose of the marker in the colour camera out.

The pose on `marker_pose/pose` is that of the marker or board (origin in its middle, x right, y
up, z out of the print) in the frame that `header.frame_id` names: the colour camera's optical
frame. Its covariance is of a shift of that origin and a turn about it, along that frame's axes.
`marker_pose/seen` lists the numbers of the marker, or of the board's inner corners, that it rests
on: whoever looks at depth there need not look at what covers the others.
"""

from collections.abc import Callable
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import InputError
from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.marker_tracker import MarkerTracker
from diffcal_ros.live.node_words import told_of
from diffcal_ros.live.stream_meter import StreamMeter
from diffcal_ros.marker import Board, Marker
from diffcal_ros.pose.detection import CornerRefinement
from diffcal_ros.pose.marker_depth import DepthEvidence
from diffcal_ros.pose.pose_drawing import draw_pose
from diffcal_ros.pose.rig_pose import RigPose
from diffcal_ros.pose.target import Target, target_of
from diffcal_ros.recording.topics.camera_infos import camera_of
from diffcal_ros.recording.topics.color_frame import ColorFrame
from diffcal_ros.ros.adaptive_subscription import AdaptiveSubscription, noting
from diffcal_ros.ros.conversion import (
    color_frame,
    depth_camera,
    depth_frame,
    image_message,
    pose_message,
    seen_message,
    stamp_ns,
    transform_matrix,
)
from diffcal_ros.ros.diagnostics import DiagnosticsReporter, PERIOD
from diffcal_ros.ros.frame_sender import check_frame_names, FrameSender
from diffcal_ros.ros.parameters import Parameters, Setting, Values
from diffcal_ros.ros.qos import IMAGES, VALUES
from diffcal_ros.scene.load import load_scene
from diffcal_ros.user_path import user_path
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped
import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Int32MultiArray

FloatArray = NDArray[np.float64]

_SECOND = 1_000_000_000  # [ns]
_OF_MARKER = ('marker.', 'board.')
_SCENE_FIRST = "the scene's marker goes before them; set the parameter scene to '' to use them"
COLOR, COLOR_INFO = 'color/image_raw', 'color/camera_info'
DEPTH, DEPTH_INFO = 'depth/image_rect_raw', 'depth/camera_info'
SETTINGS = (
    Setting('scene', '', 'scene file whose marker is looked for; empty: the one below'),
    Setting('marker.dictionary', 'DICT_6X6_250', "OpenCV's name of the dictionary"),
    Setting('marker.id', 0, 'number of the marker in the dictionary', 0, 1_000_000),
    Setting('marker.side', 0.02, 'edge of its black square [m]', 0.001, 10.0),
    Setting('board.columns', 0, 'squares across a ChArUco board; 0: a single marker', 0, 100),
    Setting('board.rows', 0, 'squares down that board', 0, 100),
    Setting('board.square', 0.03, 'edge of its squares [m]', 0.001, 10.0),
    Setting('board.legacy', False, 'it was made by OpenCV before 4.6, with an even row count'),
    Setting('window', 30, 'frames that are fused into one pose', 1, 300),
    Setting('max_rate', 10.0, 'frames a second that are looked at', 0.1, 1000.0),
    Setting(
        'corner_refinement',
        CornerRefinement.EDGES.value,
        "how the marker's corners are located",
        choices=tuple(refinement.value for refinement in CornerRefinement),
    ),
    Setting(
        'use_depth',
        True,
        'use depth on the marker, where it is seen, for distance, tilt and a check of its size',
        is_read_only=True,
    ),
    Setting(
        'publish_tf',
        True,
        'send the pose to TF, unless another node tells of that frame',
        is_read_only=True,
    ),
    Setting('marker_frame', 'marker', 'name of the frame that is sent to TF; empty: not sent'),
    PERIOD,
)


class MarkerPoseNode(Node):
    """Finds the marker in colour images and fuses what it finds."""

    def __init__(self) -> None:
        super().__init__('marker_pose')
        self._problem: str | None = None
        self._bad_inputs: dict[str, str] = {}
        self._tracker: MarkerTracker | None = None
        self._meter = StreamMeter()
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._next_ns = 0
        self._settings = Parameters(
            self, SETTINGS, check=_check, check_change=_check_change, act=self._changed
        )
        unused = _unused(self._settings.values)
        if unused:
            self.get_logger().warning(f'{", ".join(unused)} not used: {_SCENE_FIRST}')
        self._frames = FrameSender(self) if self._settings['publish_tf'] else None
        overriding = QoSOverridingOptions.with_default_policies()
        self._pose = self.create_publisher(
            PoseWithCovarianceStamped,
            'marker_pose/pose',
            VALUES,
            qos_overriding_options=overriding,
        )
        self._seen = self.create_publisher(
            Int32MultiArray, 'marker_pose/seen', VALUES, qos_overriding_options=overriding
        )
        self._debug = self.create_publisher(
            Image, 'marker_pose/debug_image', IMAGES, qos_overriding_options=overriding
        )
        self._camera: PinholeCamera | None = None
        self._depth: bytes | None = None
        self._depth_camera: PinholeCamera | None = None
        self._depth_from_color: FloatArray | None = None
        self._make_tracker()
        self._listeners = self._subscribe_all()
        self._reporter = DiagnosticsReporter(self, self._examine, self._settings[PERIOD.name])

    def close(self) -> bool:
        """Nothing runs on."""
        return True

    def _make_tracker(self) -> None:
        """Look for the marker that the parameters name."""
        try:
            self._tracker = MarkerTracker(
                _target(self._settings.values),
                window=self._settings['window'],
                refinement=CornerRefinement(self._settings['corner_refinement']),
            )
            self._problem = None
            if self._camera is not None:
                self._tracker.set_camera(self._camera)
        except InputError as error:
            self._tracker = None
            self._problem = str(error)

    def _changed(self, names: frozenset[str]) -> None:
        if names - {'max_rate', 'marker_frame'}:
            self._make_tracker()

    def _subscribe_all(self) -> list[AdaptiveSubscription]:
        subscriptions = [
            # One image waits at most: the newest is looked at next.
            self._subscribe(Image, COLOR, self._on_color, depth=1, on_lost=self._on_lost),
            self._subscribe(CameraInfo, COLOR_INFO, self._on_color_info),
        ]
        if self._settings['use_depth']:
            subscriptions += [
                self._subscribe(Image, DEPTH, self._on_depth, depth=1, is_raw=True),
                self._subscribe(CameraInfo, DEPTH_INFO, self._on_depth_info),
                self._subscribe(
                    TransformStamped, 'depth_from_color', self._on_transform, is_latched=True
                ),
            ]
        return subscriptions

    def _subscribe(
        self, msg_type: Any, topic: str, callback: Callable[[Any], None], **options: Any
    ) -> AdaptiveSubscription:
        noted = noting(self._bad_inputs, topic, callback)
        return AdaptiveSubscription(self, msg_type, topic, noted, **options)

    def _on_lost(self, count: int) -> None:
        self._meter.lose(self._steady.now().nanoseconds, count)

    def _on_color_info(self, info: CameraInfo) -> None:
        topic = self._listeners[0].topic
        self._camera = camera_of(info, topic=COLOR_INFO, image_topic=topic)
        if self._tracker is not None:
            self._tracker.set_camera(self._camera)

    def _on_depth(self, serialized: bytes) -> None:
        # Decoded only when a colour image is looked at.
        self._depth = serialized

    def _on_depth_info(self, info: CameraInfo) -> None:
        self._depth_camera = depth_camera(info, DEPTH_INFO, self.resolve_topic_name(DEPTH))

    def _on_transform(self, message: TransformStamped) -> None:
        self._depth_from_color = transform_matrix(message.transform)

    def _on_color(self, image: Image) -> None:
        now = self._steady.now().nanoseconds
        self._meter.arrived(now, stamp_ns(image.header.stamp))
        if now < self._next_ns or self._tracker is None:
            return
        self._next_ns = now + int(_SECOND / self._settings['max_rate'])
        frame = color_frame(image)
        if not frame.frame_id:
            raise ValueError('frame_id is empty: the pose needs a frame to be in')
        pose = self._tracker.add(frame.image, frame.stamp_ns, self._evidence())
        if pose is not None:
            self._send(image, pose)
        if self._debug.get_subscription_count():
            self._draw(frame, pose)

    def _evidence(self) -> DepthEvidence | None:
        """Return the newest depth image, where all that belongs to it is there."""
        camera, depth_from_color = self._depth_camera, self._depth_from_color
        if self._depth is None or camera is None or depth_from_color is None:
            return None
        try:
            frame = depth_frame(deserialize_message(self._depth, Image))
        except ValueError as error:
            self._bad_inputs[DEPTH] = str(error)
            return None
        self._bad_inputs.pop(DEPTH, None)
        return DepthEvidence(frame.depth, camera, depth_from_color)

    def _send(self, image: Image, pose: RigPose) -> None:
        message = PoseWithCovarianceStamped(header=image.header)
        message.pose.pose = pose_message(pose.camera_from_marker)
        message.pose.covariance = pose.covariance.ravel()
        # First, so that it is there when the pose is used.
        self._seen.publish(seen_message(pose.seen_ids))
        self._pose.publish(message)
        if self._frames is not None:
            child = self._settings['marker_frame']
            header = image.header
            self._frames.send(
                stamp_ns(header.stamp), header.frame_id, child, pose.camera_from_marker
            )

    def _draw(self, frame: ColorFrame, pose: RigPose | None) -> None:
        tracker = self._tracker
        if tracker is None or tracker.detection is None or self._camera is None:
            return
        drawn = draw_pose(
            frame.image,
            self._camera,
            tracker.detection,
            None if pose is None else pose.camera_from_marker,
            length=_reach(tracker.target),
        )
        self._debug.publish(
            image_message(drawn, encoding='bgr8', time_ns=frame.stamp_ns, frame_id=frame.frame_id)
        )

    def _examine(self) -> dict[str, Health]:
        now = self._steady.now().nanoseconds
        figures = self._meter.figures(now, self.get_clock().now().nanoseconds)
        if self._tracker is None:
            return {'pose': Health(Level.ERROR, self._problem or 'no marker', figures)}
        for topic, reason in self._bad_inputs.items():
            return {'pose': Health(Level.ERROR, told_of(topic, reason), figures)}
        health = self._tracker.health()
        values = {**figures, **health.values}
        trouble = self._meter.trouble(now, 'colour images')
        if trouble is not None and health.level is Level.OK:
            return {'pose': Health(Level.WARN, f'{health.message}; {trouble[1]}', values)}
        return {'pose': Health(health.level, health.message, values)}


def _reach(target: Target) -> float:
    """Return half the size of a target [m]."""
    corners = np.concatenate(list(target.corners.values()))
    return 0.5 * float(np.ptp(corners, axis=0).max())


def _unused(values: Values) -> list[str]:
    """Return parameters of a marker that are given beside a scene."""
    usual = {setting.name: setting.default for setting in SETTINGS}
    if not values['scene']:
        return []
    return [n for n in usual if n.startswith(_OF_MARKER) and values[n] != usual[n]]


def _check(values: Values) -> None:
    check_frame_names(values['marker_frame'])


def _check_change(old: Values, new: Values) -> None:
    """Refuse a change after which nothing could be found, or which would change nothing."""
    changed = [name for name in new if name.startswith(_OF_MARKER) and new[name] != old[name]]
    if new['scene'] and changed:
        raise InputError(f'{", ".join(changed)} would not be used: {_SCENE_FIRST}')
    # Of a board, columns and rows may come one after the other.
    is_half = bool(new['board.columns']) != bool(new['board.rows'])
    if new['scene'] != old['scene'] or (changed and not is_half):
        _target(new)


def _target(values: Values) -> Target:
    """Return the marker or board to look for.

    Raises:
        InputError: when the scene has none, or there is no such marker.
    """
    if not values['scene']:
        return target_of(_marker(values))
    scene = load_scene(user_path(values['scene']))
    if scene.marker is None:
        raise InputError(
            f"{values['scene']} has no 'marker': add its dictionary, id and side, or give the "
            'parameters marker.dictionary, marker.id and marker.side'
        )
    return target_of(scene.marker)


def _marker(values: Values) -> Marker:
    """Return the marker or board that the parameters name."""
    columns, rows = values['board.columns'], values['board.rows']
    board = None
    if columns or rows:
        board = Board(columns, rows, values['board.square'], values['board.legacy'])
    return Marker(
        values['marker.dictionary'], values['marker.id'], values['marker.side'], board=board
    )
