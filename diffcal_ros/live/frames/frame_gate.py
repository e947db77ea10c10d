# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Let good live images pass and count the bad ones by what is wrong with them."""

from collections import Counter
from dataclasses import dataclass

from diffcal_ros.depth_frame import ENCODINGS as DEPTH_ENCODINGS
from diffcal_ros.recording.topics.color_frame import COLOR_ENCODINGS

_JUMP = 100_000_000  # [ns]
# Bytes of a pixel.
_DEPTH_BYTES = {name: 4 if name == '32FC1' else 2 for name in DEPTH_ENCODINGS}
_COLOR_BYTES = {
    name: 1 if name == 'mono8' else 4 if name.endswith('a8') else 3 for name in COLOR_ENCODINGS
}


@dataclass(frozen=True)
class ImageFacts:
    """What an image message says about itself.

    Attributes:
        encoding: as sensor_msgs names it.
        width: columns [px].
        height: rows [px].
        step: bytes from one row to the next.
        byte_count: bytes that it holds.
        stamp_ns: [ns].
        frame_id: optical frame.
    """

    encoding: str
    width: int
    height: int
    step: int
    byte_count: int
    stamp_ns: int
    frame_id: str


class FrameGate:
    """Checks the images of one topic."""

    def __init__(self, topic: str, *, is_depth: bool) -> None:
        """Start without any image.

        Args:
            topic: for messages.
            is_depth: the images hold depth, not colour.
        """
        self.topic = topic
        self.passed = 0
        self.bad: Counter[str] = Counter()
        self.camera_size: tuple[int, int] | None = None
        self._encodings = _DEPTH_BYTES if is_depth else _COLOR_BYTES
        self._last_stamp_ns = 0

    def check(self, facts: ImageFacts) -> str | None:
        """Return what is wrong with an image, or None; count it."""
        problem = self._problem(facts)
        self._last_stamp_ns = facts.stamp_ns
        if problem is None:
            self.passed += 1
        else:
            self.bad[problem] += 1
        return problem

    def _problem(self, facts: ImageFacts) -> str | None:
        size = (facts.width, facts.height)
        if facts.encoding not in self._encodings:
            allowed = ', '.join(self._encodings)
            return f'encoding is {facts.encoding!r}, {allowed} are understood'
        row = facts.width * self._encodings[facts.encoding]
        if facts.step < row:
            return f'step is {facts.step} bytes, {facts.width} {facts.encoding} pixels take {row}'
        if facts.step * facts.height > facts.byte_count:
            return 'the message is cut off'
        if self.camera_size is not None and size != self.camera_size:
            columns, rows = self.camera_size
            return f'image of {size[0]}x{size[1]}, camera_info says {columns}x{rows}'
        if not facts.frame_id:
            return 'frame_id is empty'
        if facts.stamp_ns == 0:
            return 'stamp is zero'
        # One backward jump is a clock that was set, and what follows it is good again.
        if facts.stamp_ns < self._last_stamp_ns - _JUMP:
            return 'stamp lies before the last one'
        return None
