# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Open a recording: which topics, which cameras, and where the colour camera is."""

import os
from pathlib import Path
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import RecordingError
from diffcal_ros.plain_text import listed, plain
from diffcal_ros.recording.bag.bag_files import bag_files
from diffcal_ros.recording.bag.mcap_messages import McapMessages, RawMessage
from diffcal_ros.recording.recording import Recording
from diffcal_ros.recording.topics.camera_infos import camera_of, require_size, require_undistorted
from diffcal_ros.recording.topics.image_topics import choose_color, choose_depth, ImageTopic
from diffcal_ros.recording.topics.names import camera_info_of, CAMERA_INFO_TYPE
from diffcal_ros.recording.topics.recorded_frames import LeftOut, own_topics, read_still_frames
from diffcal_ros.recording.topics.ros_messages import deserialize, matrix_of
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_OWN_TOPIC = 'depth_from_color'
_SCENE_CURE = 'correct it in the scene, or leave it out to use the camera_info'


def open_recording(
    path: str | os.PathLike[str],
    *,
    depth_topic: str | None = None,
    color_topic: str | None = None,
    depth_camera: PinholeCamera | None = None,
    color_camera: PinholeCamera | None = None,
    allow_truncated: bool = False,
) -> Recording:
    """Open a rosbag2 directory or a bare .mcap file.

    The files are read once and their checksums compared; images are read when asked for.

    Args:
        path: directory, with or without metadata.yaml, or file.
        depth_topic: needed when there are several.
        color_topic: None chooses by name.
        depth_camera: used in place of camera_info.
        color_camera: likewise.
        allow_truncated: use what can be read of damaged, cut-off and missing files; a note
            says what is lost.

    Raises:
        RecordingError: when the recording cannot be used; says why and what to do.
    """
    messages = McapMessages(bag_files(Path(path)), allow_truncated=allow_truncated)
    depth = choose_depth(messages, depth_topic)
    camera = _depth_camera(messages, depth, depth_camera)
    color, seen_by, problem = _color(messages, color_topic, color_camera)
    unreadable: list[tuple[RawMessage, ValueError]] = []

    def left_out(raw: RawMessage, error: ValueError) -> None:
        unreadable.append((raw, error))

    depth_from_color = (
        None if color is None else _depth_from_color(messages, depth, color, left_out)
    )
    recording = Recording(
        path=Path(path),
        sha256=messages.sha256,
        depth_topic=depth.name,
        depth_camera=camera,
        depth_frame_id=depth.frame_id,
        color_topic=None if color is None else color.name,
        color_camera=seen_by,
        color_frame_id='' if color is None else color.frame_id,
        depth_from_color=depth_from_color,
        topic_counts={name: len(messages.entries(name)) for name in sorted(messages.types)},
        color_problem=problem,
        saved_count=messages.saved_count,
        lost_counts=messages.lost,
        notes=(*messages.notes, *([problem] if problem else [])),
        messages=messages,
        is_depth_camera_given=depth_camera is not None,
        is_color_camera_given=color_camera is not None,
    )
    for raw, error in unreadable:
        recording.leave_out(raw, error)
    return recording


def _depth_camera(
    messages: McapMessages, depth: ImageTopic, given: PinholeCamera | None
) -> PinholeCamera:
    topic = camera_info_of(depth.name)
    if given is None:
        info = _camera_info(messages, topic)
        if info is None:
            others = [
                plain(name)
                for name, type_name in sorted(messages.types.items())
                if type_name == CAMERA_INFO_TYPE
            ]
            have = f'the recording has {listed(others)}' if others else 'there is none at all'
            raise RecordingError(
                f'there is no camera_info {topic} for {depth.name} ({have}): record it, or give '
                "the intrinsics in the scene file under 'camera'"
            )
        camera = camera_of(info, topic=topic, image_topic=depth.name)
        require_undistorted(camera, topic=topic, image_topic=depth.name)
        require_size(camera, depth.width, depth.height, topic=topic, image_topic=depth.name)
    else:
        camera = given
        require_size(
            camera,
            depth.width,
            depth.height,
            topic="the scene's camera",
            image_topic=depth.name,
            cure=_SCENE_CURE,
        )
    return camera


def _color(
    messages: McapMessages, wanted: str | None, given: PinholeCamera | None
) -> tuple[ImageTopic | None, PinholeCamera | None, str]:
    """Choose the colour topic and its camera; what is wrong there is told, and no error."""
    ranked = choose_color(messages, wanted)
    if not ranked:
        return None, None, ''
    color = ranked[0]
    topic = camera_info_of(color.name)
    info = None if given is not None else _camera_info(messages, topic)
    if given is None and info is None:
        return color, None, f'there is no camera_info {topic} for {color.name}'
    try:
        if given is None:
            camera = camera_of(info, topic=topic, image_topic=color.name)
            _require_color_size(camera, color, topic)
        else:
            camera = given
            _require_color_size(camera, color, "the scene's color_camera", cure=_SCENE_CURE)
    except RecordingError as error:
        return color, None, str(error)
    return color, camera, ''


def _require_color_size(camera: PinholeCamera, color: ImageTopic, owner: str, **cure: str) -> None:
    # The size of compressed images is known only when they are unpacked.
    if not color.is_compressed:
        require_size(
            camera, color.width, color.height, topic=owner, image_topic=color.name, **cure
        )


def _camera_info(messages: McapMessages, topic: str) -> Any:
    """Return the first readable camera_info of a topic, or None."""
    if messages.types.get(topic) != CAMERA_INFO_TYPE:
        return None
    for raw in messages.read(topic):
        try:
            return deserialize(raw.data, CAMERA_INFO_TYPE)
        except ValueError:
            continue
    return None


def _depth_from_color(
    messages: McapMessages, depth: ImageTopic, color: ImageTopic, left_out: LeftOut
) -> FloatArray | None:
    """Return where the colour camera is, or None when the recording does not say."""
    if depth.frame_id and color.frame_id:
        return read_still_frames(messages, left_out).find(depth.frame_id, color.frame_id)
    # Images without frame names: the topic's own name says which transform it is.
    for name, stamped in own_topics(messages, left_out).items():
        if name.endswith(_OWN_TOPIC):
            try:
                return matrix_of(stamped)
            except ValueError as error:
                raise RecordingError(
                    f'the transform on {name} is unusable, {error}: record it again'
                ) from error
    return None
