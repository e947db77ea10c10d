# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Choose the depth and the colour topic of a recording, by type, encoding and name."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

from diffcal_ros.depth_frame import ENCODINGS as DEPTH_ENCODINGS
from diffcal_ros.errors import RecordingError
from diffcal_ros.plain_text import listed, plain
from diffcal_ros.recording.bag.mcap_messages import McapMessages
from diffcal_ros.recording.topics.color_frame import COLOR_ENCODINGS
from diffcal_ros.recording.topics.compressed_depth import unpack_depth
from diffcal_ros.recording.topics.names import (
    camera_info_of,
    CAMERA_INFO_TYPE,
    COLOR_IMAGE,
    COMPRESSED,
    COMPRESSED_DEPTH,
    COMPRESSED_IMAGE_TYPE,
    DEPTH_IMAGE,
    IMAGE_TYPE,
    plain_topic,
)
from diffcal_ros.recording.topics.ros_messages import deserialize

# One damaged message at the start must not decide what a topic is.
_LOOKED_AT = 3


@dataclass(frozen=True)
class ImageTopic:
    """A topic of images.

    Attributes:
        name: absolute.
        encoding: of its first readable message, unpacked where it is depth; empty when none of
            the first ones is readable.
        width: columns [px]; 0 for compressed colour.
        height: rows [px]; 0 for compressed colour.
        frame_id: optical frame.
        problem: why none of the first images is readable; empty where one is.
    """

    name: str
    encoding: str
    width: int = 0
    height: int = 0
    frame_id: str = ''
    problem: str = ''

    @property
    def is_compressed(self) -> bool:
        """Tell whether it carries pictures as JPEG or PNG."""
        return self.name.endswith(COMPRESSED)

    @property
    def is_depth(self) -> bool:
        """Tell whether it carries depth; 16-bit grey does when its name says so."""
        named = 'depth' in self.name
        return self.encoding in DEPTH_ENCODINGS and (self.encoding != 'mono16' or named)

    @property
    def is_color(self) -> bool:
        """Tell whether it carries colour or grey pictures for the eye."""
        return self.encoding in COLOR_ENCODINGS or self.is_compressed


def image_topics(messages: McapMessages) -> tuple[ImageTopic, ...]:
    """List the image topics of a recording, by name."""
    return tuple(
        _look_at(messages, name)
        for name, type_name in sorted(messages.types.items())
        if type_name == IMAGE_TYPE
        or (type_name == COMPRESSED_IMAGE_TYPE and name.endswith((COMPRESSED, COMPRESSED_DEPTH)))
    )


def choose_depth(messages: McapMessages, wanted: str | None) -> ImageTopic:
    """Choose the depth topic.

    Raises:
        RecordingError: when there is none, the wanted one is missing or carries no depth, or
            there are several and none is wanted.
    """
    topics = image_topics(messages)
    if wanted is not None:
        return _wanted_depth(topics, f'/{wanted.lstrip("/")}', messages)
    names = {topic.name for topic in topics if topic.is_depth}
    # What was recorded as it is and packed as well is one topic.
    depth = [
        topic
        for topic in topics
        if topic.is_depth and plain_topic(topic.name) not in names - {topic.name}
    ]
    if len(depth) > 1:
        raise RecordingError(
            f'the recording has {len(depth)} depth topics, '
            f'{listed([plain(topic.name) for topic in depth])}: choose one with --depth-topic'
        )
    if depth:
        return depth[0]
    named = [topic for topic in topics if 'depth' in topic.name and not topic.is_compressed]
    if named:
        raise _unknown_encoding(named[0])
    raise RecordingError(
        'the recording has no depth topic, '
        f'{"only" if messages.types else "and holds"} {listing(messages, topics)}: record '
        f'{DEPTH_IMAGE} (sensor_msgs/msg/Image, 32FC1 or 16UC1), or its compressedDepth'
    )


def choose_color(messages: McapMessages, wanted: str | None) -> tuple[ImageTopic, ...]:
    """Rank the colour topics, the best first; none is no error.

    Raises:
        RecordingError: when the wanted one is missing or carries no colour.
    """
    topics = image_topics(messages)
    if wanted is not None:
        name = f'/{wanted.lstrip("/")}'
        found = [topic for topic in topics if topic.name == name and topic.is_color]
        if not found:
            raise RecordingError(
                f'{name} is no colour topic of the recording, which has '
                f'{listing(messages, topics)}: choose another with --color-topic'
            )
        return tuple(found)

    def rank(topic: ImageTopic) -> tuple[bool, ...]:
        return (
            topic.name != COLOR_IMAGE,
            messages.types.get(camera_info_of(topic.name)) != CAMERA_INFO_TYPE,
            'infra' in topic.name or 'debug' in topic.name,
            topic.is_compressed,
            not ('color' in topic.name or 'rgb' in topic.name),
        )

    return tuple(sorted((topic for topic in topics if topic.is_color), key=rank))


def listing(messages: McapMessages, topics: Sequence[ImageTopic]) -> str:
    """Name what a recording holds."""
    encodings = {topic.name: f', {plain(topic.encoding)}' for topic in topics if topic.encoding}
    shown = [
        f'{plain(name)} ({plain(type_name)}{encodings.get(name, "")})'
        for name, type_name in sorted(messages.types.items())
    ]
    return listed(shown) or 'nothing'


def _wanted_depth(topics: Sequence[ImageTopic], name: str, messages: McapMessages) -> ImageTopic:
    for topic in topics:
        # The plain name stands for its packed images, too; it comes first where both are there.
        if topic.name in (name, f'{name}{COMPRESSED_DEPTH}'):
            if topic.encoding not in DEPTH_ENCODINGS:
                raise _unknown_encoding(topic)
            return topic
    raise RecordingError(
        f'{name} is no image topic of the recording, which has {listing(messages, topics)}: '
        'choose another with --depth-topic'
    )


def _unknown_encoding(topic: ImageTopic) -> RecordingError:
    if not topic.encoding:
        return RecordingError(
            f'none of the first images on {plain(topic.name)} can be read '
            f'({plain(topic.problem, 200)}): record it again, or choose another topic with '
            '--depth-topic'
        )
    return RecordingError(
        f'{plain(topic.name)} has the encoding {plain(topic.encoding)!r}: depth comes as 32FC1 '
        '(metres) or 16UC1 (millimetres); record it so, or choose another topic with '
        '--depth-topic'
    )


def _look_at(messages: McapMessages, name: str) -> ImageTopic:
    type_name = messages.types[name]
    if type_name == COMPRESSED_IMAGE_TYPE and name.endswith(COMPRESSED):
        return ImageTopic(name, '', frame_id=_compressed_frame(messages, name))
    problem = 'there is none'
    for raw in islice(messages.read(name, messages.entries(name)[:_LOOKED_AT]), _LOOKED_AT):
        try:
            image = deserialize(raw.data, type_name)
            if type_name == COMPRESSED_IMAGE_TYPE:
                image = unpack_depth(image)
        except ValueError as error:
            problem = str(error)
            continue
        return ImageTopic(
            name, str(image.encoding), image.width, image.height, str(image.header.frame_id)
        )
    return ImageTopic(name, '', problem=problem)


def _compressed_frame(messages: McapMessages, name: str) -> str:
    for raw in messages.read(name, messages.entries(name)[:1]):
        try:
            return str(deserialize(raw.data, COMPRESSED_IMAGE_TYPE).header.frame_id)
        except ValueError:
            break
    return ''
