# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an accelerometer at rest felt: the direction against gravity."""

from dataclasses import dataclass

from diffcal_ros.recording.bag.mcap_messages import McapMessages
from diffcal_ros.recording.topics.frame_tree import FrameTree
from diffcal_ros.recording.topics.recorded_frames import LeftOut
from diffcal_ros.recording.topics.ros_messages import deserialize
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

IMU_TYPE = 'sensor_msgs/msg/Imu'
# At rest an accelerometer feels about this [m/s^2].
_AT_REST = (8.8, 10.8)
_MOST_MESSAGES = 500


@dataclass(frozen=True)
class RestingImu:
    """An accelerometer at rest.

    Attributes:
        topic: name.
        frame_id: of the sensor.
        acceleration: mean of what it felt, which points away from the ground [m/s^2], shape (3,).
    """

    topic: str
    frame_id: str
    acceleration: FloatArray

    @property
    def is_plausible(self) -> bool:
        """Tell whether it felt about gravity and nothing else."""
        return _AT_REST[0] <= float(np.linalg.norm(self.acceleration)) <= _AT_REST[1]

    def down_in(self, frame_id: str, tree: FrameTree) -> FloatArray | None:
        """Return gravity's direction in another frame, unit, shape (3,); None: no way there."""
        frame_from_imu = (
            np.eye(4)
            if frame_id.lstrip('/') == self.frame_id.lstrip('/')
            else tree.find(frame_id, self.frame_id)
        )
        if frame_from_imu is None:
            return None
        down: FloatArray = frame_from_imu[:3, :3] @ -self.acceleration
        return down / np.linalg.norm(down)


def read_imus(messages: McapMessages, left_out: LeftOut) -> list[RestingImu]:
    """Read what each accelerometer of a recording felt on average.

    Topics without a readable acceleration are left out: a driver that has gyroscope and
    accelerometer apart fills one of the two with zeros.

    Args:
        messages: of the recording.
        left_out: told of messages that cannot be read.
    """
    found = []
    for topic, type_name in sorted(messages.types.items()):
        if type_name != IMU_TYPE:
            continue
        entries = messages.entries(topic)
        felt, frame_id = [], ''
        for raw in messages.read(topic, entries[:: max(1, len(entries) // _MOST_MESSAGES)]):
            try:
                message = deserialize(raw.data, IMU_TYPE)
            except ValueError as error:
                left_out(raw, error)
                continue
            own = message.linear_acceleration
            felt.append((own.x, own.y, own.z))
            frame_id = str(message.header.frame_id)
        mean = np.mean(felt, axis=0) if felt else np.zeros(3)
        if np.isfinite(mean).all() and mean.any():
            found.append(RestingImu(topic, frame_id, np.asarray(mean, dtype=np.float64)))
    return found
