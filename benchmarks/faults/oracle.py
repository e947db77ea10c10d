# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read a damaged file and judge what came of it, by what is known of the damage alone."""

from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
import signal
import time

from diffcal_ros.errors import InputError
from diffcal_ros.recording.bag_reader import open_recording
import numpy as np

from benchmarks.faults.damage import Damage
from benchmarks.faults.layouts import Recorded, Written

PATIENCE = 10.0  # [s]
DEPTH, COLOR = '/depth/image_rect_raw', '/color/image_raw'
# What a note says of a recording that is not as it was made.
_TOLD = ('truncated', 'damaged', 'metadata.yaml counts')
FAULTS = (
    *('traceback', 'hang', 'silent loss', 'changed unsaid', 'miscounted', 'refused needlessly'),
    *('refused unsaid', 'left running', 'half a file'),
)


@dataclass(frozen=True)
class Verdict:
    """What came of reading a file.

    Attributes:
        outcome: refused, read whole, read in part, topic renamed (by a flipped bit in a file in
            which nothing states the name twice), or one of `FAULTS`.
        detail: in words.
        intact: images that the damage did not hit.
        saved: those of them that were read.
        seconds: how long it took [s].
    """

    outcome: str
    detail: str = ''
    intact: int = 0
    saved: int = 0
    seconds: float = 0.0


def judge(bag: Path, truth: 'Truth', *, is_tolerant: bool) -> Verdict:
    """Read a damaged recording and judge."""
    begun = time.perf_counter()
    try:
        with time_limit():
            found = _read(bag, is_tolerant=is_tolerant)
    except InputError as error:
        outcome, detail = truth.judge_refusal(str(error))
        return Verdict(outcome, detail, truth.intact, 0, time.perf_counter() - begun)
    except HangError:
        return Verdict('hang', '', truth.intact, 0, PATIENCE)
    except Exception as error:
        return Verdict('traceback', repr(error), truth.intact, 0, time.perf_counter() - begun)
    seconds = time.perf_counter() - begun
    outcome, detail = truth.judge(found)
    return Verdict(outcome, detail, truth.intact, truth.saved(found), seconds)


@dataclass(frozen=True)
class _Found:
    """What the reader handed out."""

    counts: Counter[str]
    images: dict[str, dict[int, bytes]]
    skipped: int
    is_told: bool
    lost: dict[str, int]
    is_counted: bool


def _read(file: Path, *, is_tolerant: bool) -> _Found:
    recording = open_recording(file, allow_truncated=is_tolerant)
    images = {
        DEPTH: {frame.stamp_ns: frame.depth.tobytes() for frame in recording.depth_frames()},
        COLOR: {frame.stamp_ns: frame.image.tobytes() for frame in recording.color_frames()},
    }
    told = ' '.join(recording.notes)
    return _Found(
        counts=Counter(recording.topic_counts),
        images=images,
        skipped=sum(recording.skipped.values()),
        is_told=any(word in told for word in _TOLD),
        lost=getattr(recording, 'lost_counts', {}),
        is_counted='not known' not in told,
    )


class Truth:
    """What there is to be found in a damaged recording."""

    def __init__(self, written: Written, damage: Damage, beside: Sequence[Recorded] = ()) -> None:
        """Take what is known.

        Args:
            written: the file before it was damaged.
            damage: what happened to it.
            beside: messages of another file of the bag, which is sound.
        """
        self._damage = damage
        self._layout = written.layout
        self._all = Counter(message.topic for message in (*written.messages, *beside))
        self._total = self._all.total()
        self._descriptions = [
            (place.start, place.end) for place in written.places if place.kind == 'description'
        ]
        self._whole = _images((*written.messages, *beside))
        left = [
            written.messages[number]
            for place in written.places
            if place.messages and not damage.hits(place.start, place.end)
            for number in place.messages
        ]
        self._intact = _images((*left, *beside))

    @property
    def intact(self) -> int:
        return sum(len(images) for images in self._intact.values())

    def saved(self, found: _Found) -> int:
        return sum(
            found.images[topic].get(stamp) == image
            for topic, images in self._intact.items()
            for stamp, image in images.items()
        )

    def judge_refusal(self, message: str) -> tuple[str, str]:
        # Damage may have hit nothing: then the recording must be read.
        is_whole = not self._damage.spoilt and self._layout.has_end
        if is_whole or len(message) > 600:
            return 'refused needlessly', message
        return 'refused', message

    def judge(self, found: _Found) -> tuple[str, str]:
        outcome, detail = self._judge(found)
        if outcome == 'silent loss' and self._is_renamed and found.counts.total() == self._total:
            return 'topic renamed', detail
        return outcome, detail

    @property
    def _is_renamed(self) -> bool:
        """Tell whether a topic or type has another name and nothing in the file can show it."""
        is_bare = self._layout.compression is None and not self._layout.has_summary
        return is_bare and any(self._damage.hits(*place) for place in self._descriptions)

    def _judge(self, found: _Found) -> tuple[str, str]:
        lost = self._all - found.counts
        if (lost or found.counts - self._all) and not found.is_told:
            return 'silent loss', f'{dict(lost)}'
        missing = {
            topic: len(self._whole[topic]) - len(found.images[topic]) for topic in self._whole
        }
        if sum(missing.values()) > found.skipped + sum(lost.values()):
            return 'silent loss', f'{missing}'
        if self._is_protected() and not found.is_told and self._changed(found):
            return 'changed unsaid', ''
        if self._layout.has_chunk_checksums and self._changed(found):
            return 'changed unsaid', 'the checksum of its chunk was there'
        if found.is_told and found.is_counted and Counter(found.lost) != lost:
            return 'miscounted', f'told {found.lost}, lost are {dict(lost)}'
        return ('read in part' if lost else 'read whole'), ''

    def _is_protected(self) -> bool:
        return self._layout.has_data_checksum

    def _changed(self, found: _Found) -> bool:
        """Tell whether an image came out otherwise than it was recorded."""
        return any(
            self._whole[topic].get(stamp) != image
            for topic, images in found.images.items()
            for stamp, image in images.items()
        )


def pixels_of(message: Recorded) -> bytes:
    """Return an image as the reader hands it out: metres of depth, the bytes of colour."""
    _, pixels = _pixels(message.data)
    return _metres(pixels) if message.topic == DEPTH else pixels.tobytes()


def _images(messages: Sequence[Recorded]) -> dict[str, dict[int, bytes]]:
    images: dict[str, dict[int, bytes]] = {DEPTH: {}, COLOR: {}}
    for message in messages:
        if message.topic in images:
            stamp, pixels = _pixels(message.data)
            images[message.topic][stamp] = (
                _metres(pixels) if message.topic == DEPTH else pixels.tobytes()
            )
    return images


def _pixels(data: bytes) -> tuple[int, np.ndarray]:
    """Take stamp and pixels out of an Image, by the layout of CDR."""
    second, nano = np.frombuffer(data, '<u4', 2, 4)
    # The pixels are the last field.
    place = 4 + 8
    place = _behind_text(data, place)
    place = _aligned(place) + 8
    place = _behind_text(data, place)
    place = _aligned(place + 1) + 4
    size = int(np.frombuffer(data, '<u4', 1, place)[0])
    return int(second) * 10**9 + int(nano), np.frombuffer(data, np.uint8, size, place + 4)


def _behind_text(data: bytes, place: int) -> int:
    place = _aligned(place)
    return place + 4 + int(np.frombuffer(data, '<u4', 1, place)[0])


def _aligned(place: int) -> int:
    # CDR counts from behind its own head of four bytes.
    return (place + 3) // 4 * 4


def _metres(pixels: np.ndarray) -> bytes:
    depth = pixels.view('<f4').copy()
    depth[~(np.isfinite(depth) & (depth > 0.0))] = np.nan
    return depth.tobytes()


class HangError(BaseException):
    """The reader did not come back in time."""


@contextmanager
def time_limit() -> Iterator[None]:
    """Raise `HangError` in what takes too long."""

    def stop(*_) -> None:
        raise HangError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
