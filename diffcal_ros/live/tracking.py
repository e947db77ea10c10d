# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that is followed on live frames: what is handed over, counted and remembered."""

from collections import deque
from dataclasses import dataclass, field, replace
import threading
import time

from diffcal_ros.calibration.calibrate import with_details
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.tracking.body_change import BodyChange
from diffcal_ros.calibration.tracking.tracked import TrackerSettings
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.live.frames.latest_frame import LatestFrame, Order
from diffcal_ros.live.picture import Picture
from diffcal_ros.live.tasks.background import Background
from diffcal_ros.live.tasks.fit_task import FitEnd
from diffcal_ros.live.tasks.track_task import track, TrackRequest, TrackStep
import numpy as np

_LATENCIES = 16384  # Nine minutes at 30 Hz.
_STILL = 30  # So many frames with one stamp are not an accident.


@dataclass(frozen=True)
class TrackingSettings:
    """How a body is followed on live frames.

    Attributes:
        tracker: how to follow it.
        picture_rate: pictures a second at most [Hz], while somebody looks.
    """

    tracker: TrackerSettings = field(default_factory=TrackerSettings)
    picture_rate: float = 2.0


class Tracking:
    """Follows one body, in a thread of its own.

    Attributes:
        frames: where frames are handed over.
        last: the newest step; None before the first frame.
        picture: the last one; None before somebody looked.
        change: the last change of the body; None without one.
        change_count: changes that were told.
        has_onlookers: somebody wants pictures; set from outside.
    """

    def __init__(self, end: FitEnd, settings: TrackingSettings, background: Background) -> None:
        """Start.

        Args:
            end: of the fit to start from.
            settings: how to follow.
            background: has nothing else to do.
        """
        self.frames = LatestFrame()
        self.last: TrackStep | None = None
        self.picture: Picture | None = None
        self.change: BodyChange | None = None
        self.change_count = 0
        self.has_onlookers = False
        self._is_still = 0
        self._latencies: deque[int] = deque(maxlen=_LATENCIES)
        self._picture = _Pace(settings.picture_rate)
        request = TrackRequest(end, settings.tracker, self.frames, self._is_picture_due)
        self._stop: threading.Event = background.submit(
            lambda post, stop: track(request, post, stop)
        )

    def stop(self) -> None:
        """End it."""
        self._stop.set()

    def put(self, frame: DepthFrame, now_ns: int) -> None:
        """Hand over a frame that arrived at a steady time [ns]."""
        order = self.frames.put(frame, now_ns)
        self._is_still = self._is_still + 1 if order is Order.REPEATED else 0

    def handle(self, step: TrackStep) -> None:
        """Take in what is known after a frame."""
        self.last = step
        if step.tracked.change is not None:
            self.change = step.tracked.change
            self.change_count += 1

    def told(self, step: TrackStep, now_ns: int) -> None:
        """Note when a step was published, steady time [ns]."""
        self._latencies.append(now_ns - step.arrived_ns)

    def alike(self, frames: tuple[DepthFrame, ...]) -> tuple[DepthFrame, ...]:
        """Return those frames that show the body as it is now, the newest at least."""
        if self.change is None:
            return frames
        since = self.change.stamp_ns
        return tuple(frame for frame in frames if frame.stamp_ns >= since) or frames[-1:]

    def result(self, fitted: CalibrationResult) -> CalibrationResult:
        """Return the result of the fit brought up to date; its history stays."""
        if self.last is None:
            return fitted
        tracked = self.last.tracked
        return with_details(
            replace(
                fitted,
                parameters=tracked.parameters,
                gap_end=tracked.gap,
                correlation=tracked.correlation,
            ),
            tracking={'stamp_ns': tracked.stamp_ns, **self.figures()},
        )

    @property
    def problem(self) -> str | None:
        """What is wrong with the frames, or None."""
        if self._is_still >= _STILL:
            return (
                'the stamps of the depth images stand still: a body is followed in time, the '
                'driver must stamp every image'
            )
        if self.last is not None and not self.last.tracked.is_found:
            return 'the body is not where the model says: look for what hides or moved it'
        return None

    def latency_ms(self, percentile: float) -> float:
        """Return a percentile of the times from a frame to its parameters [ms]; NaN without."""
        latencies = self._latencies
        return float(np.percentile(latencies, percentile)) / 1e6 if latencies else float('nan')

    def figures(self) -> dict[str, str]:
        """Return the figures for a diagnosis."""
        frames, last = self.frames, self.last
        values = {
            'frames used': str(0 if last is None else last.number),
            'frames skipped': str(frames.skipped),
            'frames refused for their stamp': str(frames.refused.total()),
            'latency median [ms]': f'{self.latency_ms(50.0):.2f}',
            'latency 99 % [ms]': f'{self.latency_ms(99.0):.2f}',
            'changes': str(self.change_count),
            'last change': 'none' if self.change is None else in_words(self.change),
        }
        if last is not None:
            values['update time [s]'] = f'{last.seconds:.4f}'
            values['searches'] = str(last.search_count)
            values['frames worth'] = f'{last.tracked.frames_worth:.1f}'
        return values

    def _is_picture_due(self) -> bool:
        return self.has_onlookers and self._picture.is_due()


class _Pace:
    """Lets something happen so many times a second."""

    def __init__(self, rate: float) -> None:
        self._period = 1.0 / rate if rate > 0.0 else float('inf')
        self._next = 0.0

    def is_due(self) -> bool:
        """Tell whether it is time again."""
        now = time.monotonic()
        if now < self._next:
            return False
        self._next = now + self._period
        return True


def in_words(change: BodyChange) -> str:
    """Say in a sentence what changed."""
    parts = [
        f'{name} {value:.4g} -> {change.after[name]:.4g}' for name, value in change.before.items()
    ]
    if change.gap_after > change.gap_before:
        parts.append(
            f'median gap {1e3 * change.gap_before:.2f} -> {1e3 * change.gap_after:.2f} mm'
        )
    how = 'suddenly' if change.is_sudden else 'by and by'
    return f'{how}: {", ".join(parts)}'
