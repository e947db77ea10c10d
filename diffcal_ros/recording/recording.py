# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An opened recording and its frames."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import decode_depth, DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.plain_text import plain
from diffcal_ros.recording.bag.mcap_messages import McapMessages, RawMessage
from diffcal_ros.recording.mcap_file.index import Entry
from diffcal_ros.recording.topics.camera_watch import CameraWatch
from diffcal_ros.recording.topics.color_frame import ColorFrame, decode_color, decode_compressed
from diffcal_ros.recording.topics.compressed_depth import unpack_depth
from diffcal_ros.recording.topics.names import COMPRESSED_IMAGE_TYPE
from diffcal_ros.recording.topics.ros_messages import deserialize, stamp_ns_of
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Frame = TypeVar('Frame', DepthFrame, ColorFrame)

_NO_DEPTH = 'no pixel holds a depth'


@dataclass(frozen=True)
class Recording:
    """A recording that is known to hold depth images and their camera.

    Attributes:
        path: as given.
        sha256: of the mcap files, one after the other.
        depth_topic: name.
        depth_camera: intrinsics of the depth images, without distortion.
        depth_frame_id: optical frame of the depth images.
        color_topic: name, or None.
        color_camera: intrinsics of the colour images, or None when not known.
        color_frame_id: optical frame of the colour images, or empty.
        depth_from_color: from the colour to the depth camera's frame, shape (4, 4), or None.
        topic_counts: messages of each topic.
        color_problem: why `color_camera` is not known; empty where it is.
        saved_count: messages that can be read of a damaged recording; None for a whole one.
        lost_counts: messages that cannot be read, by topic, as far as the recording tells.
        notes: what is odd, in sentences.
        messages: everything that was recorded.
        is_depth_camera_given: whether `depth_camera` comes from elsewhere.
        is_color_camera_given: likewise.
    """

    path: Path
    sha256: str
    depth_topic: str
    depth_camera: PinholeCamera
    depth_frame_id: str
    color_topic: str | None
    color_camera: PinholeCamera | None
    color_frame_id: str
    depth_from_color: FloatArray | None
    topic_counts: dict[str, int]
    color_problem: str
    saved_count: int | None
    lost_counts: dict[str, int]
    notes: tuple[str, ...]
    messages: McapMessages = field(repr=False)
    is_depth_camera_given: bool = False
    is_color_camera_given: bool = False
    _skipped: dict[tuple[str, Entry], str] = field(default_factory=dict, repr=False)

    @property
    def depth_count(self) -> int:
        """Depth images, good and bad."""
        return self.topic_counts[self.depth_topic]

    @property
    def color_count(self) -> int:
        """Colour images, good and bad."""
        return 0 if self.color_topic is None else self.topic_counts[self.color_topic]

    @property
    def skipped(self) -> Counter[str]:
        """Messages left out so far, counted by topic and reason; whoever reads finds them."""
        return Counter(f'{topic}: {reason}' for (topic, _), reason in self._skipped.items())

    @property
    def left_out(self) -> tuple[str, ...]:
        """The same in sentences."""
        return tuple(f'{count} messages left out: {why}' for why, count in self.skipped.items())

    @property
    def first_stamp_ns(self) -> int:
        """When the first readable depth image was taken [ns]."""
        return self._end_stamp(1)

    @property
    def last_stamp_ns(self) -> int:
        """When the last readable depth image was taken [ns]."""
        return self._end_stamp(-1)

    def depth_frames(self, limit: int | None = None) -> Iterator[DepthFrame]:
        """Read depth images one by one, in the order of recording.

        Args:
            limit: at most so many, evenly spaced over the recording; a bad one gives its place
                to a neighbour. None for all.

        Raises:
            RecordingError: after the last one, when none was good.
        """
        count = 0
        for frame in self._frames(self.depth_topic, self._depth_frame, limit):
            count += 1
            yield frame
        if not count:
            raise self._nothing_good()

    def depth_stamps(self) -> list[int | None]:
        """Return the header stamps of all depth images [ns], None for an unreadable one."""
        stamps: list[int | None] = []
        for raw in self.messages.read(self.depth_topic):
            try:
                stamps.append(stamp_ns_of(deserialize(raw.data, raw.type_name)))
            except ValueError:
                stamps.append(None)
        return stamps

    def depth_frames_at(self, indices: Sequence[int]) -> Iterator[DepthFrame | None]:
        """Read the depth images at some places of the recording; None for a bad one."""
        entries = self.messages.entries(self.depth_topic)
        chosen = [entries[index] for index in indices]
        for raw in self._watch(self.depth_topic)(chosen):
            try:
                yield self._depth_frame(raw)
            except ValueError as error:
                self.leave_out(raw, error)
                yield None

    def color_frames(self, limit: int | None = None) -> Iterator[ColorFrame]:
        """Read colour images likewise; none is no error."""
        if self.color_topic is not None:
            yield from self._frames(self.color_topic, self._color_frame, limit)

    def _frames(
        self, topic: str, decode: Callable[[RawMessage], Frame], limit: int | None
    ) -> Iterator[Frame]:
        if limit is not None and limit < 1:
            raise RecordingError(f'{limit} frames were asked for: at least one is needed')
        entries = self.messages.entries(topic)
        read = self._watch(topic)
        for indices in _indices(len(entries), limit):
            for raw in read([entries[index] for index in indices]):
                try:
                    frame = decode(raw)
                except ValueError as error:
                    self.leave_out(raw, error)
                    continue
                yield frame
                if limit is not None:
                    break

    def _watch(self, topic: str) -> Callable[[Sequence[Entry]], Iterator[RawMessage]]:
        """Return how images are read: with an eye on their camera where it was recorded."""
        is_depth = topic == self.depth_topic
        camera = self.depth_camera if is_depth else self.color_camera
        is_given = self.is_depth_camera_given if is_depth else self.is_color_camera_given
        if camera is None or is_given:
            return lambda entries: self.messages.read(topic, entries)
        return CameraWatch(self.messages, topic, camera).read

    def leave_out(self, raw: RawMessage, reason: ValueError) -> None:
        """Count a message that cannot be used, once."""
        self._skipped[raw.topic, raw.entry] = plain(str(reason), 200)

    def _depth_frame(self, raw: RawMessage) -> DepthFrame:
        image = deserialize(raw.data, raw.type_name)
        if raw.type_name == COMPRESSED_IMAGE_TYPE:
            image = unpack_depth(image)
        camera = self.depth_camera
        if (image.width, image.height) != (camera.width, camera.height):
            raise ValueError(
                f'image of {image.width}x{image.height}, camera_info says '
                f'{camera.width}x{camera.height}'
            )
        depth = decode_depth(
            image.data,
            encoding=image.encoding,
            width=image.width,
            height=image.height,
            step=image.step,
            is_bigendian=bool(image.is_bigendian),
        )
        if not np.isfinite(depth).any():
            raise ValueError(_NO_DEPTH)
        return DepthFrame(depth, stamp_ns_of(image), str(image.header.frame_id))

    def _color_frame(self, raw: RawMessage) -> ColorFrame:
        image = deserialize(raw.data, raw.type_name)
        if raw.type_name == COMPRESSED_IMAGE_TYPE:
            pixels = decode_compressed(image.data)
        else:
            pixels = decode_color(
                image.data,
                encoding=image.encoding,
                width=image.width,
                height=image.height,
                step=image.step,
            )
        camera = self.color_camera
        if camera is not None and pixels.shape[:2] != (camera.height, camera.width):
            raise ValueError(
                f'image of {pixels.shape[1]}x{pixels.shape[0]}, camera_info says '
                f'{camera.width}x{camera.height}'
            )
        return ColorFrame(pixels, stamp_ns_of(image), str(image.header.frame_id))

    def _end_stamp(self, step: int) -> int:
        entries = self.messages.entries(self.depth_topic)[::step]
        for raw in self.messages.read(self.depth_topic, entries):
            try:
                return stamp_ns_of(deserialize(raw.data, raw.type_name))
            except ValueError:
                continue
        return entries[0].log_time_ns

    def _nothing_good(self) -> RecordingError:
        reasons = Counter(
            reason for (topic, _), reason in self._skipped.items() if topic == self.depth_topic
        )
        if set(reasons) == {_NO_DEPTH}:
            return RecordingError(
                f'{self.depth_topic} holds no depth in any of {reasons[_NO_DEPTH]} frames, all '
                'zero or NaN: check the range and the laser of the camera, and record again'
            )
        told = '; '.join(f'{count} times: {reason}' for reason, count in reasons.most_common())
        return RecordingError(
            f'{self.depth_topic} has no usable frame ({told}): check the recording'
        )


def _indices(count: int, limit: int | None) -> Iterator[list[int]]:
    """Split a sequence into `limit` runs, in each the middle first; or give all in one run."""
    if limit is None:
        yield list(range(count))
        return
    for run in np.array_split(np.arange(count), min(limit, max(count, 1))):
        middle = (len(run) - 1) / 2.0
        yield [int(run[k]) for k in sorted(range(len(run)), key=lambda k: abs(k - middle))]
