# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read the transforms of a recording: /tf_static, /tf and those on topics of their own."""

from collections.abc import Callable
from typing import Any

from diffcal_ros.recording.bag.mcap_messages import McapMessages, RawMessage
from diffcal_ros.recording.topics.frame_tree import FrameTree
from diffcal_ros.recording.topics.names import TF, TF_STATIC, TF_TYPE, TRANSFORM_TYPE
from diffcal_ros.recording.topics.ros_messages import deserialize, matrix_of, stamp_ns_of
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Told of each message that cannot be read, and why.
LeftOut = Callable[[RawMessage, ValueError], None]


def read_still_frames(messages: McapMessages, left_out: LeftOut) -> FrameTree:
    """Read the transforms that do not change."""
    tree = FrameTree()
    for stamped in own_topics(messages, left_out).values():
        _add(tree, stamped)
    for stamped in _transforms(messages, TF_STATIC, left_out):
        _add(tree, stamped)
    return tree


def still_transforms(
    messages: McapMessages, left_out: LeftOut
) -> list[tuple[str, str, FloatArray]]:
    """List the usable transforms that do not change: parent, child, parent_from_child (4, 4)."""
    found: dict[str, tuple[str, str, FloatArray]] = {}
    for stamped in (
        *own_topics(messages, left_out).values(),
        *_transforms(messages, TF_STATIC, left_out),
    ):
        try:
            matrix = matrix_of(stamped)
        except ValueError:
            continue
        parent, child = str(stamped.header.frame_id), str(stamped.child_frame_id)
        found[child] = (parent, child, matrix)
    return list(found.values())


def read_frames(messages: McapMessages, left_out: LeftOut) -> FrameTree:
    """Read all transforms, those that change with their times."""
    tree = read_still_frames(messages, left_out)
    for stamped in _transforms(messages, TF, left_out):
        _add(tree, stamped, stamp_ns_of(stamped))
    return tree


def own_topics(messages: McapMessages, left_out: LeftOut) -> dict[str, Any]:
    """Return the first readable transform of each topic that carries single ones."""
    found: dict[str, Any] = {}
    for topic, type_name in messages.types.items():
        if type_name != TRANSFORM_TYPE:
            continue
        for raw in messages.read(topic):
            try:
                found[topic] = deserialize(raw.data, TRANSFORM_TYPE)
                break
            except ValueError as error:
                left_out(raw, error)
    return found


def moving_topics(messages: McapMessages) -> list[str]:
    """Name the topics of transforms that change: /tf, of any namespace."""
    return _topics(messages, TF)


def _topics(messages: McapMessages, name: str) -> list[str]:
    return [
        topic
        for topic, type_name in messages.types.items()
        if type_name == TF_TYPE and topic.endswith(name)
    ]


def _transforms(messages: McapMessages, name: str, left_out: LeftOut) -> list[Any]:
    """List what stands on /tf or /tf_static, of any namespace."""
    found: list[Any] = []
    for topic in _topics(messages, name):
        for raw in messages.read(topic):
            try:
                found += deserialize(raw.data, TF_TYPE).transforms
            except ValueError as error:
                left_out(raw, error)
    return found


def _add(tree: FrameTree, stamped: Any, stamp_ns: int | None = None) -> None:
    parent, child = str(stamped.header.frame_id), str(stamped.child_frame_id)
    try:
        matrix = matrix_of(stamped)
    except ValueError as error:
        tree.add(parent, child, None, problem=str(error))
        return
    tree.add(parent, child, matrix, stamp_ns=stamp_ns)
