# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Messages of a recording in the order of replay, serialised, with stamps that go on in loops."""

from collections.abc import Callable, Iterator
from enum import Enum
from typing import NamedTuple

from diffcal_ros.live.replay.cdr_stamp import move_stamp
from diffcal_ros.recording.bag.mcap_messages import RawMessage
from diffcal_ros.recording.recording import Recording
from diffcal_ros.recording.topics.color_frame import decode_compressed
from diffcal_ros.recording.topics.compressed_depth import unpack_depth
from diffcal_ros.recording.topics.names import (
    camera_info_of,
    COMPRESSED_DEPTH,
    COMPRESSED_IMAGE_TYPE,
    TF,
    TF_TYPE,
)
from diffcal_ros.recording.topics.recorded_frames import moving_topics
from diffcal_ros.recording.topics.ros_messages import (
    deserialize,
    image_message,
    serialize,
    stamp_ns_of,
)

_SECOND = 1_000_000_000  # [ns]
_USUAL_PERIOD = 33_333_333  # [ns]
# Of transforms so much before the first image is sent: an image may show what was then [ns].
_LEAD = _SECOND


class Role(str, Enum):
    """What a message is to the nodes; the values are their topics."""

    DEPTH = 'depth/image_rect_raw'
    DEPTH_INFO = 'depth/camera_info'
    COLOR = 'color/image_raw'
    COLOR_INFO = 'color/camera_info'
    FRAMES = TF


class ReplayMessage(NamedTuple):
    """A message and its time.

    Attributes:
        role: what it is.
        time_ns: when it was recorded, moved on in later rounds [ns].
        data: CDR bytes.
    """

    role: Role
    time_ns: int
    data: bytes


def replay_messages(
    recording: Recording, goes_on: Callable[[], bool], left_out: Callable[[str], None]
) -> Iterator[ReplayMessage]:
    """Walk through a recording, again and again.

    Args:
        recording: opened.
        goes_on: asked at the end of each round.
        left_out: told of each message that cannot be unpacked or has no stamp, and why.
    """
    roles = _roles(recording)
    first, period = _round(recording, tuple(roles))
    roles.update(dict.fromkeys(moving_topics(recording.messages), Role.FRAMES))
    shift, lead = 0, _LEAD
    while True:
        for raw in recording.messages.read_all(tuple(roles)):
            role = roles[raw.topic]
            # Images say how long a round is; what moved after it would fall into the next one.
            if role is Role.FRAMES and not -lead <= raw.log_time_ns - first < period:
                continue
            try:
                data = _moved(raw, role, shift)
            except ValueError as error:
                left_out(f'{raw.topic}: {error}')
                continue
            yield ReplayMessage(role, raw.log_time_ns + shift, data)
        if not goes_on():
            return
        shift, lead = shift + period, 0


def _roles(recording: Recording) -> dict[str, Role]:
    """Say what each topic of use is."""
    named = {recording.depth_topic: Role.DEPTH}
    named[camera_info_of(recording.depth_topic)] = Role.DEPTH_INFO
    if recording.color_topic is not None:
        named[recording.color_topic] = Role.COLOR
        # Cameras that share a namespace share a camera_info only by mistake: depth goes first.
        named.setdefault(camera_info_of(recording.color_topic), Role.COLOR_INFO)
    return {topic: role for topic, role in named.items() if topic in recording.messages.types}


def _round(recording: Recording, topics: tuple[str, ...]) -> tuple[int, int]:
    """Return when the first image was recorded, and by how much stamps go on a round [ns]."""
    entries = [entry for topic in topics for entry in recording.messages.entries(topic)]
    times = [entry.log_time_ns for entry in entries]
    count = len(recording.messages.entries(recording.depth_topic))
    span = max(times) - min(times)
    pause = span // (count - 1) if count > 1 and span > 0 else _USUAL_PERIOD
    return min(times), span + pause


def _moved(raw: RawMessage, role: Role, shift: int) -> bytes:
    """Return the message to send, with its stamps moved by a time [ns]."""
    return _moved_frames(raw, shift) if role is Role.FRAMES else move_stamp(_as_image(raw), shift)


def _moved_frames(raw: RawMessage, shift: int) -> bytes:
    frames = deserialize(raw.data, TF_TYPE)
    for stamped in frames.transforms if shift else ():
        stamp = stamped.header.stamp
        stamp.sec, stamp.nanosec = divmod(stamp_ns_of(stamped) + shift, _SECOND)
    return serialize(frames) if shift else raw.data


def _as_image(raw: RawMessage) -> bytes:
    """Return the message as it was recorded; a compressed image is unpacked."""
    if raw.type_name != COMPRESSED_IMAGE_TYPE:
        return raw.data
    packed = deserialize(raw.data, raw.type_name)
    if raw.topic.endswith(COMPRESSED_DEPTH):
        return serialize(unpack_depth(packed))
    return serialize(
        image_message(
            decode_compressed(packed.data),
            encoding='bgr8',
            stamp_ns=stamp_ns_of(packed),
            frame_id=str(packed.header.frame_id),
        )
    )
