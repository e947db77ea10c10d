# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""See to it that a camera stays the same while its images are read."""

from bisect import bisect_right
from collections.abc import Iterator, Sequence

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag.mcap_messages import McapMessages, RawMessage
from diffcal_ros.recording.mcap_file.index import Entry
from diffcal_ros.recording.topics.camera_infos import camera_of
from diffcal_ros.recording.topics.names import camera_info_of, CAMERA_INFO_TYPE
from diffcal_ros.recording.topics.ros_messages import deserialize

# What moves no pixel by more is no change, such as digits that were rounded [px].
_TOLERANCE = 0.1
# CDR's own head and the stamp, which differ from message to message.
_BEFORE_CONTENT = 12


class CameraWatch:
    """Reads images, and beside each the camera_info that was recorded with it."""

    def __init__(self, messages: McapMessages, image_topic: str, camera: PinholeCamera) -> None:
        """Watch a camera.

        Args:
            messages: of a recording.
            image_topic: its images.
            camera: what its first camera_info says.
        """
        self._messages = messages
        self._image_topic = image_topic
        self._topic = camera_info_of(image_topic)
        self._camera = camera
        is_info = messages.types.get(self._topic) == CAMERA_INFO_TYPE
        self._infos = messages.entries(self._topic) if is_info else []
        self._looked_at: set[Entry] = set()
        self._contents: set[bytes] = set()

    def read(self, entries: Sequence[Entry]) -> Iterator[RawMessage]:
        """Read images.

        Raises:
            RecordingError: when the camera has changed, or bytes have.
        """
        places: list[tuple[str, Entry]] = []
        for entry in entries:
            info = self._beside(entry)
            if info is not None and info not in self._looked_at:
                self._looked_at.add(info)
                places.append((self._topic, info))
            places.append((self._image_topic, entry))
        for raw in self._messages.read_each(places):
            if raw.topic == self._image_topic:
                yield raw
            else:
                self._compare(raw)

    def _beside(self, image: Entry) -> Entry | None:
        """Return the camera_info that was recorded nearest to an image."""
        place = bisect_right(self._infos, _order(image), key=_order)
        near = self._infos[max(place - 1, 0) : place + 1]
        return min(near, key=lambda info: _distance(info, image), default=None)

    def _compare(self, raw: RawMessage) -> None:
        content = raw.data[_BEFORE_CONTENT:]
        if content in self._contents:
            return
        self._contents.add(content)
        try:
            info = deserialize(raw.data, CAMERA_INFO_TYPE)
        except ValueError:
            return
        now = camera_of(info, topic=self._topic, image_topic=self._image_topic)
        if _moved(self._camera, now) > _TOLERANCE:
            raise RecordingError(
                f'{self._topic} changes within the recording, from {_words(self._camera)} to '
                f'{_words(now)}: record with one resolution, zoom and focus, or cut the '
                'recording where they change'
            )


def _order(entry: Entry) -> tuple[int, int]:
    return entry.file, entry.log_time_ns


def _distance(info: Entry, image: Entry) -> tuple[int, int]:
    return abs(info.file - image.file), abs(info.log_time_ns - image.log_time_ns)


def _moved(before: PinholeCamera, now: PinholeCamera) -> float:
    """Return how far a pixel moves at most, roughly [px]."""
    if (before.width, before.height) != (now.width, now.height):
        return float('inf')
    if before.distortion != now.distortion:
        return float('inf')
    return max(
        abs(now.cx - before.cx) + abs(now.fx / before.fx - 1.0) * before.width,
        abs(now.cy - before.cy) + abs(now.fy / before.fy - 1.0) * before.height,
    )


def _words(camera: PinholeCamera) -> str:
    distorted = ', distorted' if camera.is_distorted else ''
    return (
        f'{camera.width}x{camera.height} pixels with fx={camera.fx:g}, fy={camera.fy:g}, '
        f'cx={camera.cx:g}, cy={camera.cy:g}{distorted}'
    )
