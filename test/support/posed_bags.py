# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The filmed beam with transforms and poses beside it, and scenes that use them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
import json
from pathlib import Path
from typing import Any

from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import (
    COLOR_FRAME,
    DEPTH_FRAME,
    POSE_COVARIANCE_TYPE,
    POSE_TYPE,
    TF_TYPE,
)
from diffcal_ros.recording.topics.ros_messages import header, message, transform_message
from diffcal_ros.rigid_transform import quaternion_xyzw
from diffcal_ros.scene.model import PoseSetup, Scene
from diffcal_ros.synthetic.recorder import SyntheticRecording
import numpy as np

Extra = Callable[[BagWriter, Sequence[int]], None]


def true_pose(recorded: SyntheticRecording) -> np.ndarray:
    """Return depth_from_world of the filmed beam, shape (4, 4)."""
    truth = json.loads(recorded.truth.read_text())['observations']['observation']
    return np.array(truth['depth_from_world'])


def posed(scene: Scene, **pose: Any) -> Scene:
    """Return the scene of one observation with another `pose` section."""
    (setup,) = scene.observations
    return replace(scene, observations=(replace(setup, pose=PoseSetup(**pose)),))


def copy_beam(recorded: SyntheticRecording, path: Path, extra: Extra) -> Path:
    """Copy the depth images, with what `extra` writes for their stamps beside them."""
    source = open_recording(recorded.bags['observation'])
    with BagWriter(path) as bag:
        stamps = []
        for frame in source.depth_frames():
            stamp = frame.stamp_ns
            bag.write_depth_camera(source.depth_camera, stamp_ns=stamp, frame_id=DEPTH_FRAME)
            bag.write_depth(frame)
            stamps.append(stamp)
        bag.write_depth_from_color(
            source.depth_from_color,
            depth_frame=DEPTH_FRAME,
            color_frame=COLOR_FRAME,
            stamp_ns=stamps[0],
        )
        extra(bag, stamps)
    return path


def send_tf(
    bag: BagWriter,
    topic: str,
    parent_from_child: np.ndarray,
    parent: str,
    child: str,
    stamp_ns: int,
    *,
    is_turned: bool = True,
) -> None:
    """Write one transform; without its rotation the quaternion is zero."""
    stamped = transform_message(parent_from_child, parent=parent, child=child, stamp_ns=stamp_ns)
    if not is_turned:
        turn = stamped.transform.rotation
        turn.x = turn.y = turn.z = turn.w = 0.0
    bag.write(topic, message(TF_TYPE, transforms=[stamped]), stamp_ns)


def spoil(bag: BagWriter, topics: Sequence[str], stamp_ns: int) -> None:
    """Write a message that is cut off on each of some topics, which have whole ones."""
    for topic in topics:
        bag._writer.add_message(bag._channels[topic], stamp_ns, b'\x00\x01\x00\x00\x07', stamp_ns)
        bag._counts[topic] += 1


def pose_message(
    matrix: np.ndarray, frame: str, stamp_ns: int, covariance: np.ndarray | None = None
) -> Any:
    """Make a PoseStamped, or with a covariance a PoseWithCovarianceStamped."""
    x, y, z = (float(value) for value in matrix[:3, 3])
    place = message('geometry_msgs/msg/Point', x=x, y=y, z=z)
    a, b, c, w = (float(value) for value in quaternion_xyzw(matrix[:3, :3]))
    turn = message('geometry_msgs/msg/Quaternion', x=a, y=b, z=c, w=w)
    pose = message('geometry_msgs/msg/Pose', position=place, orientation=turn)
    if covariance is None:
        return message(POSE_TYPE, header=header(stamp_ns, frame), pose=pose)
    known = message(
        'geometry_msgs/msg/PoseWithCovariance', pose=pose, covariance=covariance.ravel()
    )
    return message(POSE_COVARIANCE_TYPE, header=header(stamp_ns, frame), pose=known)
