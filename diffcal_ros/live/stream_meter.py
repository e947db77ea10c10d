# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rate, delay and losses of a stream of messages."""

from collections import deque

from diffcal_ros.live.health import Level
import numpy as np

_SECOND = 1_000_000_000  # [ns]
_RATE_SPAN = 2 * _SECOND
_DELAYS = 2048
# What went wrong so long ago is no longer told [ns].
_RECENT = 10 * _SECOND
# Without a message for so long, and for so many of its usual periods, a stream falters or is dead.
_FALTERS, _IS_DEAD = 3.0, 8.0
_FALTERING_PERIODS, _DEAD_PERIODS = 5.0, 15.0


class Recent:
    """Counts what happened lately, to the second."""

    def __init__(self) -> None:
        self._counts: deque[tuple[int, int]] = deque()

    def add(self, now_ns: int, count: int = 1) -> None:
        """Count something at a steady time [ns]."""
        second = now_ns // _SECOND
        if self._counts and self._counts[-1][0] == second:
            count += self._counts.pop()[1]
        self._counts.append((second, count))
        self._forget(now_ns)

    def count(self, now_ns: int) -> int:
        """Return how often it happened within the last ten seconds."""
        self._forget(now_ns)
        return sum(count for _, count in self._counts)

    def _forget(self, now_ns: int) -> None:
        while self._counts and self._counts[0][0] * _SECOND < now_ns - _RECENT:
            self._counts.popleft()


class StreamMeter:
    """Counts what arrives; what it keeps is bounded."""

    def __init__(self) -> None:
        self.received = 0
        self.lost = 0
        self.last_stamp_ns: int | None = None
        self._lost_lately = Recent()
        self._arrivals: deque[int] = deque(maxlen=512)
        self._delays: deque[int] = deque(maxlen=_DELAYS)

    def arrived(self, now_ns: int, stamp_ns: int, delay_ns: int | None = None) -> None:
        """Count one message.

        Args:
            now_ns: steady time [ns].
            stamp_ns: its stamp [ns].
            delay_ns: since it was published [ns], where that is known.
        """
        self.received += 1
        self.last_stamp_ns = stamp_ns
        self._arrivals.append(now_ns)
        if delay_ns is not None:
            self._delays.append(delay_ns)

    def lose(self, now_ns: int, count: int) -> None:
        """Count messages that were lost, at a steady time [ns]."""
        self.lost += count
        self._lost_lately.add(now_ns, count)

    def quiet_seconds(self, now_ns: int) -> float:
        """Return how long ago the last message came [s]; 0 before the first."""
        return (now_ns - self._arrivals[-1]) / _SECOND if self._arrivals else 0.0

    def trouble(self, now_ns: int, what: str) -> tuple[Level, str] | None:
        """Say what is wrong with a stream that has begun, or None.

        Args:
            now_ns: steady time [ns].
            what: its messages, such as "depth images".
        """
        quiet, period = self.quiet_seconds(now_ns), self._usual_period()
        if quiet > max(_FALTERS, _FALTERING_PERIODS * period):
            is_dead = quiet > max(_IS_DEAD, _DEAD_PERIODS * period)
            level = Level.ERROR if is_dead else Level.WARN
            return level, f'no {what} for {quiet:.0f} s: look after the camera or its driver'
        lost = self._lost_lately.count(now_ns)
        if lost:
            return Level.WARN, (
                f'{lost} {what} were lost within 10 s: give their publisher more shared memory '
                '(config/fastdds_large_images.xml), or publish them reliably'
            )
        return None

    def _usual_period(self) -> float:
        return float(np.median(np.diff(self._arrivals))) / _SECOND if self.received > 1 else 0.0

    def rate(self, now_ns: int) -> float:
        """Return messages a second over the last two seconds."""
        recent = [arrival for arrival in self._arrivals if now_ns - arrival <= _RATE_SPAN]
        if len(recent) < 2 or recent[-1] == recent[0]:
            return 0.0
        return (len(recent) - 1) * _SECOND / (recent[-1] - recent[0])

    def delay_ms(self, percentile: float) -> float:
        """Return a percentile of the delays kept [ms]; NaN without any."""
        return float(np.percentile(self._delays, percentile)) / 1e6 if self._delays else np.nan

    def figures(self, now_ns: int, clock_ns: int) -> dict[str, str]:
        """Return the figures for a diagnosis.

        Args:
            now_ns: steady time [ns].
            clock_ns: time by the clock that the stamps follow [ns].
        """
        stamp = self.last_stamp_ns
        age = 'none yet' if stamp is None else f'{(clock_ns - stamp) / _SECOND:.3f}'
        return {
            'input rate [Hz]': f'{self.rate(now_ns):.1f}',
            'messages received': str(self.received),
            'messages lost': str(self.lost),
            'stamp age [s]': age,
            'delay median [ms]': f'{self.delay_ms(50.0):.2f}',
            'delay 99 % [ms]': f'{self.delay_ms(99.0):.2f}',
        }
