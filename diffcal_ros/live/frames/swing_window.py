# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cut a live stream into swings: a body that rests, begins to move, and is filmed for a while."""

from collections import deque
from dataclasses import dataclass
from enum import Enum

from diffcal_ros.calibration.forward.motion_check import has_changed
from diffcal_ros.depth_frame import DepthFrame

_SECOND = 1_000_000_000  # [ns]
# A body that was still for so long rests. Damped swings stand still at their turns for less.
_REST = 0.4  # [s]
# So much before the first visible movement is kept: a body that falls is let go up to 0.05 s
# before it is seen to move, and the first frames have to show rest.
_LEAD = 0.25  # [s]
# So many frames in a row that differ are no passing fault of the camera.
_MOVES = 2
_JUMP = 100_000_000  # A stamp farther back is another stretch of time [ns].
_GAP = 1.0  # After so long without a frame nobody knows what happened [s].


class Stage(str, Enum):
    """What the body does."""

    UNSETTLED = 'unsettled'
    RESTING = 'resting'
    MOVING = 'moving'


@dataclass(frozen=True)
class Swing:
    """Frames of one movement.

    Attributes:
        frames: oldest first; the first ones show rest.
        onset: when it was first seen to move, after the first frame [s].
    """

    frames: tuple[DepthFrame, ...]
    onset: float


class SwingWindow:
    """Looks for swings; of those that nobody took the newest wins.

    Attributes:
        stage: what the body does.
        since_ns: stamp since when it does [ns].
        newest_ns: stamp of the last frame; None before the first.
        seen: swings so far.
        skipped: swings that a newer one replaced before they were taken.
        skipped_frames: of these.
        refused: frames whose stamp repeated or was a little too old.
    """

    def __init__(self, duration: float) -> None:
        """Start without any frame.

        Args:
            duration: of a swing, rest before it included [s].
        """
        self._duration = duration
        self.seen = self.skipped = self.skipped_frames = self.refused = 0
        self._ready: Swing | None = None
        self.clear()

    def clear(self) -> None:
        """Forget what was seen of the present movement, and the swing that waits."""
        self.stage = Stage.UNSETTLED
        self.since_ns = 0
        self.newest_ns: int | None = None
        self._ready = None
        self._frames: deque[DepthFrame] = deque()
        self._still: DepthFrame | None = None
        self._onset_ns = 0
        self._differing = 0

    def add(self, frame: DepthFrame) -> None:
        """Take one more frame."""
        if self._is_of_another_time(frame):
            ready = self._ready
            self.clear()
            self._ready = ready
        elif self.newest_ns is not None and frame.stamp_ns <= self.newest_ns:
            self.refused += 1
            return
        self.newest_ns = frame.stamp_ns
        self._frames.append(frame)
        if self.stage is Stage.MOVING:
            self._film(frame)
        else:
            self._watch(frame)
            self._drop_old(frame.stamp_ns)

    def take(self) -> Swing | None:
        """Return the newest swing that nobody took, once."""
        taken, self._ready = self._ready, None
        return taken

    @property
    def seconds(self) -> float:
        """For how long the body has done what it does [s]."""
        return 0.0 if self.newest_ns is None else (self.newest_ns - self.since_ns) / _SECOND

    def _is_of_another_time(self, frame: DepthFrame) -> bool:
        if self.newest_ns is None or self._still is None:
            return True
        if frame.depth.shape != self._still.depth.shape:
            return True
        forward = frame.stamp_ns - self.newest_ns
        return forward < -_JUMP or forward > _GAP * _SECOND

    def _watch(self, frame: DepthFrame) -> None:
        """Look whether the body rests, or moves after a rest."""
        if self._still is None:
            self._rest_anew(frame)
        elif not has_changed(self._still.depth, frame.depth):
            self._differing = 0
            still_ns = self._still.stamp_ns
            if self.stage is Stage.UNSETTLED and frame.stamp_ns - still_ns >= _REST * _SECOND:
                self.stage, self.since_ns = Stage.RESTING, still_ns
        elif self.stage is Stage.UNSETTLED:
            self._rest_anew(frame)
        else:
            self._differing += 1
            if self._differing == 1:
                self._onset_ns = frame.stamp_ns
            elif self._differing == _MOVES:
                self.stage, self.since_ns = Stage.MOVING, self._onset_ns

    def _rest_anew(self, frame: DepthFrame) -> None:
        """Ask from this frame on whether the body rests."""
        if self.stage is not Stage.UNSETTLED or self._still is None:
            self.stage, self.since_ns = Stage.UNSETTLED, frame.stamp_ns
        self._still, self._differing = frame, 0

    def _film(self, frame: DepthFrame) -> None:
        first = self._frames[0].stamp_ns
        if frame.stamp_ns - first <= self._duration * _SECOND:
            return
        self._frames.pop()
        self.seen += 1
        if self._ready is not None:
            self.skipped += 1
            self.skipped_frames += len(self._ready.frames)
        self._ready = Swing(tuple(self._frames), (self._onset_ns - first) / _SECOND)
        self._frames.clear()
        self._frames.append(frame)
        self._rest_anew(frame)

    def _drop_old(self, now_ns: int) -> None:
        """Keep what would lead a movement that begins now, or has just begun."""
        end_ns = self._onset_ns if self._differing else now_ns
        while self._frames[0].stamp_ns < end_ns - _LEAD * _SECOND:
            self._frames.popleft()
