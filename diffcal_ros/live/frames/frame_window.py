# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The latest depth frames of a body at rest."""

from collections import deque

from diffcal_ros.depth_frame import DepthFrame

# Stamps of one camera may come a little out of order; more is a clock that was set back, or a
# recording that starts anew.
_JUMP = 100_000_000  # [ns]


class FrameWindow:
    """Keeps the newest frames; starts anew when stamps jump back or the image size changes."""

    def __init__(self, size: int) -> None:
        """Start empty.

        Args:
            size: frames that are kept.
        """
        self._frames: deque[DepthFrame] = deque(maxlen=size)
        self._begun_ns = 0
        self.fresh_count = 0

    @property
    def size(self) -> int:
        """Frames that are kept."""
        return self._frames.maxlen or 0

    @property
    def frames(self) -> tuple[DepthFrame, ...]:
        """The frames, oldest first."""
        return tuple(self._frames)

    @property
    def newest(self) -> DepthFrame | None:
        """The newest frame."""
        return self._frames[-1] if self._frames else None

    def resize(self, size: int) -> None:
        """Keep another number of frames, the newest of those there are."""
        self._frames = deque(self._frames, maxlen=size)

    def clear(self) -> None:
        """Forget all frames."""
        self._frames.clear()
        self.fresh_count = 0

    def used(self) -> None:
        """Note that the frames so far have been used; those that come now are fresh."""
        self.fresh_count = 0

    def add(self, frame: DepthFrame, now_ns: int) -> str | None:
        """Take one more frame.

        Args:
            frame: the newest.
            now_ns: steady time [ns].

        Returns:
            Why the window started anew, or None.
        """
        reason = self._break(frame)
        if reason is not None:
            self.clear()
        if not self.fresh_count:
            self._begun_ns = now_ns
        self._frames.append(frame)
        self.fresh_count += 1
        return reason

    def is_ripe(self, now_ns: int, patience_ns: int) -> bool:
        """Tell whether it is full of fresh frames, or has waited long enough for more.

        Args:
            now_ns: steady time [ns].
            patience_ns: how long after the first fresh frame a smaller number will do [ns].
        """
        if not self.fresh_count:
            return False
        return self.fresh_count >= self.size or now_ns - self._begun_ns >= patience_ns

    def _break(self, frame: DepthFrame) -> str | None:
        last = self.newest
        if last is None:
            return None
        if frame.depth.shape != last.depth.shape:
            rows, columns = frame.depth.shape
            return f'depth images are {columns}x{rows} now'
        back = last.stamp_ns - frame.stamp_ns
        if back > _JUMP:
            return f'stamps jumped back by {back / 1e9:.2f} s'
        return None
