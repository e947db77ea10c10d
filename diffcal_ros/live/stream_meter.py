# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rate, delay and losses of a stream of messages."""

from collections import deque

import numpy as np

_SECOND = 1_000_000_000  # [ns]
_RATE_SPAN = 2 * _SECOND
_DELAYS = 2048


class StreamMeter:
    """Counts what arrives; what it keeps is bounded."""

    def __init__(self) -> None:
        self.received = 0
        self.lost = 0
        self.last_stamp_ns: int | None = None
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
