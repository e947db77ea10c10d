# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Poses that were recorded: geometry_msgs/PoseStamped and PoseWithCovarianceStamped."""

from typing import Any

from diffcal_ros.errors import PoseError
from diffcal_ros.plain_text import listed, plain
from diffcal_ros.recording.bag.mcap_messages import McapMessages
from diffcal_ros.recording.topics.names import POSE_COVARIANCE_TYPE, POSE_TYPE
from diffcal_ros.recording.topics.recorded_frames import LeftOut
from diffcal_ros.recording.topics.ros_messages import deserialize, stamp_ns_of
from diffcal_ros.rigid_transform import check_rigid, rotation_from_quaternion, transform
from diffcal_ros.stamped_pose import known_covariance, StampedPose
import numpy as np

_TYPES = (POSE_TYPE, POSE_COVARIANCE_TYPE)


def read_poses(
    messages: McapMessages, wanted: str, left_out: LeftOut
) -> tuple[str, tuple[StampedPose, ...]]:
    """Read the good poses of a topic.

    Args:
        messages: of a recording.
        wanted: its name; empty: the only topic with poses.
        left_out: told of each pose that is unusable.

    Returns:
        The topic, and its poses in the order of recording, at least one.

    Raises:
        PoseError: when there is no such topic, or no pose on it is usable.
    """
    topic = _chosen(messages, wanted)
    poses: list[StampedPose] = []
    problem = ''
    for raw in messages.read(topic):
        try:
            poses.append(_pose(deserialize(raw.data, raw.type_name)))
        except ValueError as error:
            problem = str(error)
            left_out(raw, error)
    if not poses:
        raise PoseError(f'{topic} holds no usable pose ({problem}): record it again')
    return topic, tuple(poses)


def _chosen(messages: McapMessages, wanted: str) -> str:
    have = [name for name, kind in sorted(messages.types.items()) if kind in _TYPES]
    there = listed([plain(name) for name in have]) or 'none'
    if not wanted and len(have) != 1:
        raise PoseError(
            'a pose topic was asked for, but the scene does not name it, and the recording has '
            f"{there}: give 'topic' under 'pose' in the scene (PoseStamped or "
            'PoseWithCovarianceStamped)'
        )
    name = f'/{wanted.lstrip("/")}' if wanted else have[0]
    if name not in have:
        is_other = name in messages.types
        what = f'carries {plain(messages.types[name])}' if is_other else 'is not in the recording'
        raise PoseError(
            f'the pose topic {name} {what}: poses come as PoseStamped or '
            f"PoseWithCovarianceStamped, of which there is {there}; correct 'topic' under 'pose' "
            'in the scene, or record it'
        )
    return name


def _pose(message: Any) -> StampedPose:
    has_covariance = hasattr(message.pose, 'covariance')
    pose = message.pose.pose if has_covariance else message.pose
    turn, place = pose.orientation, pose.position
    rotation = rotation_from_quaternion(np.array([turn.x, turn.y, turn.z, turn.w]))
    matrix = check_rigid('pose', transform(rotation, np.array([place.x, place.y, place.z])))
    return StampedPose(
        frame_from_body=matrix,
        covariance=known_covariance(message.pose.covariance) if has_covariance else None,
        frame_id=str(message.header.frame_id),
        stamp_ns=stamp_ns_of(message),
    )
