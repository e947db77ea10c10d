# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth source: a recording, or live topics with checks, on the topics that others expect."""

from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.node_words import for_nodes
from diffcal_ros.live.replay.player import Player, ReplaySettings
from diffcal_ros.live.replay.replay_messages import ReplayMessage, Role
from diffcal_ros.recording.bag.bag_files import bag_files
from diffcal_ros.recording.recording import Recording
from diffcal_ros.recording.topics.names import COLOR_FRAME, DEPTH_FRAME
from diffcal_ros.recording.topics.recorded_frames import still_transforms
from diffcal_ros.rigid_transform import check_rigid, rotation_from_quaternion, transform
from diffcal_ros.ros.conversion import stamp_message, transform_message
from diffcal_ros.ros.diagnostics import DiagnosticsReporter, PERIOD
from diffcal_ros.ros.frame_sender import FrameSender
from diffcal_ros.ros.live_relay import LiveRelay
from diffcal_ros.ros.parameters import Parameters, Setting, Values
from diffcal_ros.ros.qos import IMAGES, LATCHED
from diffcal_ros.user_path import user_path
from geometry_msgs.msg import TransformStamped
import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger

FloatArray = NDArray[np.float64]

_UNKNOWN = [0.0] * 7
_TYPES = {
    Role.DEPTH: Image,
    Role.DEPTH_INFO: CameraInfo,
    Role.COLOR: Image,
    Role.COLOR_INFO: CameraInfo,
}
SETTINGS = (
    Setting('bag', '', 'recording to replay, rosbag2 directory or .mcap; empty: live topics'),
    Setting('rate', 1.0, "times the recording's own pace", 0.01, 100.0),
    Setting('loop', False, 'start again at the end, with stamps that go on'),
    Setting('paused', False, 'stand still; ~/step sends up to the next depth image'),
    Setting('depth_topic', '', 'depth topic of the recording, where it has several'),
    Setting('allow_truncated', False, 'use what is left of a damaged recording'),
    Setting('publish_clock', False, 'send the time of the recording on /clock', is_read_only=True),
    Setting(
        'publish_tf',
        True,
        "send a recording's /tf and /tf_static, or depth_from_color where it is given, to TF, "
        'unless another node tells of these frames',
        is_read_only=True,
    ),
    Setting(
        'wait_for_subscriber',
        10.0,
        'wait so long at most until somebody listens to depth and nobody else comes [s]',
        0.0,
        600.0,
    ),
    Setting(
        'subscribers',
        1,
        'so many must listen to depth before it counts as somebody: 2 for the other two nodes',
        1,
        100,
    ),
    Setting(
        'depth_from_color',
        _UNKNOWN,
        'live only, where TF is not there: x y z [m] and quaternion x y z w of the colour camera '
        'in the depth camera; zeros: not known',
    ),
    PERIOD,
)


class DepthSourceNode(Node):
    """Replays a recording, or passes live topics on."""

    def __init__(self) -> None:
        super().__init__('depth_source')
        self._player: Player | None = None
        self._relay: LiveRelay | None = None
        self._settings = Parameters(
            self, SETTINGS, check=_check, check_change=_check_change, act=self._changed
        )
        overriding = QoSOverridingOptions.with_default_policies()
        self._senders = {
            role: self.create_publisher(
                kind, role.value, IMAGES, qos_overriding_options=overriding
            )
            for role, kind in _TYPES.items()
        }
        self._transform = self.create_publisher(TransformStamped, 'depth_from_color', LATCHED)
        self._frames = FrameSender(self) if self._settings['publish_tf'] else None
        self._clock_sender: Any = None
        if self._settings['publish_clock']:
            self._clock_sender = self.create_publisher(Clock, '/clock', 1)
        self.create_service(Trigger, '~/step', self._on_step)
        self._start()
        self._reporter = DiagnosticsReporter(self, self._examine, self._settings[PERIOD.name])

    def close(self) -> bool:
        """End the replay."""
        self._stop()
        return True

    def opened(self, recording: Recording) -> None:
        """Send where the colour camera is, and what else of the rig does not change."""
        if self._frames is not None:
            self._frames.send_still(
                recording.first_stamp_ns, still_transforms(recording.messages, recording.leave_out)
            )
        if recording.depth_from_color is None:
            return
        self.send_transform(
            recording.depth_from_color,
            depth_frame=recording.depth_frame_id or DEPTH_FRAME,
            color_frame=recording.color_frame_id or COLOR_FRAME,
            time_ns=recording.first_stamp_ns,
        )

    def publish(self, message: ReplayMessage) -> None:
        """Send a message of the recording as it is; of transforms those that nobody else sends."""
        if message.role is Role.FRAMES:
            if self._frames is not None:
                self._frames.pass_on(message.data)
        elif self.context.ok():
            self._senders[message.role].publish(message.data)

    def tick(self, time_ns: int) -> None:
        """Send the time of the recording."""
        if self._clock_sender is not None and self.context.ok():
            self._clock_sender.publish(Clock(clock=stamp_message(time_ns)))

    def listener_count(self) -> int:
        """Return how many listen to images; 0 while fewer than asked for listen to depth."""
        if not self.context.ok():
            return 0
        depth, color = (
            self._senders[role].get_subscription_count() for role in (Role.DEPTH, Role.COLOR)
        )
        return int(depth + color) if depth >= self._settings['subscribers'] else 0

    def send_transform(
        self, depth_from_color: FloatArray, *, depth_frame: str, color_frame: str, time_ns: int
    ) -> None:
        """Send where the colour camera is, latched."""
        stamped = TransformStamped(
            child_frame_id=color_frame, transform=transform_message(depth_from_color)
        )
        stamped.header.frame_id = depth_frame
        stamped.header.stamp = stamp_message(time_ns)
        self._transform.publish(stamped)

    def _send_known(
        self, depth_from_color: FloatArray, *, depth_frame: str, color_frame: str, time_ns: int
    ) -> None:
        """Send where the colour camera is; to TF, too, where that is not where it came from."""
        if self._frames is not None and _transform_of(self._settings.values) is not None:
            edge = (depth_frame, color_frame, depth_from_color)
            self._frames.send_still(time_ns, [edge])
        self.send_transform(
            depth_from_color, depth_frame=depth_frame, color_frame=color_frame, time_ns=time_ns
        )

    def _start(self) -> None:
        values = self._settings.values
        if not values['bag']:
            known = _transform_of(values)
            self._relay = LiveRelay(self, self._senders, self._send_known, known)
            return
        settings = ReplaySettings(
            path=user_path(values['bag']),
            rate=values['rate'],
            is_looping=values['loop'],
            is_paused=values['paused'],
            depth_topic=values['depth_topic'],
            allow_truncated=values['allow_truncated'],
            patience=values['wait_for_subscriber'],
        )
        self._player = Player(settings, self)

    def _stop(self) -> None:
        if self._player is not None:
            self._player.close()
            self._player = None
        if self._relay is not None:
            self._relay.destroy()
            self._relay = None

    def _changed(self, names: frozenset[str]) -> None:
        values = self._settings.values
        has_ended = self._player is not None and self._player.has_ended
        if has_ended and 'loop' in names and values['loop']:
            self.get_logger().info('the replay had ended: it starts again, and goes on in a loop')
            self._stop()
            self._start()
        elif self._player is not None and names <= {'rate', 'loop', 'paused'}:
            self._player.change(
                rate=values['rate'], is_looping=values['loop'], is_paused=values['paused']
            )
        elif names - {'wait_for_subscriber', 'subscribers'}:
            self._stop()
            self._start()

    def _examine(self) -> dict[str, Health]:
        if self._player is not None:
            return {'replay': self._player.health()}
        if self._relay is not None:
            return self._relay.health()
        return {'replay': Health(Level.ERROR, 'ended')}

    def _on_step(self, request: Any, response: Any) -> Any:
        try:
            if self._player is None:
                raise InputError("live topics cannot be stepped through: set the parameter 'bag'")
            self._player.step()
        except InputError as error:
            response.success, response.message = False, for_nodes(str(error))
            return response
        response.success, response.message = True, 'sending up to the next depth image'
        return response


def _check(values: Values) -> None:
    _transform_of(values)


def _check_change(old: Values, new: Values) -> None:
    """Refuse a recording that is not there; what is in it is seen when it is opened."""
    if new['bag'] and new['bag'] != old['bag']:
        bag_files(user_path(new['bag']))


def _transform_of(values: Values) -> FloatArray | None:
    """Return depth_from_color as given, or None when it is not known."""
    numbers = np.array(values['depth_from_color'], dtype=np.float64)
    if not numbers.any():
        return None
    if numbers.shape != (7,):
        raise InputError(
            f'depth_from_color has {len(numbers)} numbers: give x y z in metres and the '
            'quaternion x y z w'
        )
    try:
        matrix = transform(rotation_from_quaternion(numbers[3:]), numbers[:3])
        return check_rigid('depth_from_color', matrix)
    except ValueError as error:
        raise InputError(str(error)) from error
