# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hand frames from one thread to another: the newest wins, what it replaces is counted."""

from collections import Counter
from dataclasses import dataclass
from enum import Enum
import threading

from diffcal_ros.depth_frame import DepthFrame

# Stamps of one camera may come a little out of order; more is a clock that was set back, or a
# recording that starts anew.
_JUMP = 100_000_000  # [ns]


class Order(str, Enum):
    """How a frame's stamp follows the one before."""

    ON_TIME = 'on time'
    REPEATED = 'repeated stamp'
    LATE = 'older than the frame before'
    RESTART = 'stamps jumped back'


@dataclass(frozen=True)
class Arrived:
    """A frame to be used.

    Attributes:
        frame: the newest.
        arrived_ns: when it came, steady time [ns].
        is_restart: its stamp jumped back: a stretch of time of its own begins.
    """

    frame: DepthFrame
    arrived_ns: int
    is_restart: bool


class LatestFrame:
    """Holds at most one frame.

    Attributes:
        received: frames put in.
        skipped: frames that a newer one replaced before they were taken.
        refused: frames whose stamp repeated or was too old, by reason.
    """

    def __init__(self) -> None:
        self.received = self.skipped = 0
        self.refused: Counter[Order] = Counter()
        self._changed = threading.Condition()
        self._waiting: Arrived | None = None
        self._last_ns: int | None = None

    def put(self, frame: DepthFrame, now_ns: int) -> Order:
        """Put the newest frame in; return how its stamp follows the one before.

        Args:
            frame: with a stamp.
            now_ns: steady time [ns].
        """
        with self._changed:
            self.received += 1
            order = self._order(frame.stamp_ns)
            if order in (Order.REPEATED, Order.LATE):
                self.refused[order] += 1
                return order
            self._last_ns = frame.stamp_ns
            is_restart = order is Order.RESTART
            if self._waiting is not None:
                self.skipped += 1
                is_restart |= self._waiting.is_restart
            self._waiting = Arrived(frame, now_ns, is_restart)
            self._changed.notify()
        return order

    def take(self, timeout: float) -> Arrived | None:
        """Wait for a frame and take it out.

        Args:
            timeout: how long to wait [s].
        """
        with self._changed:
            if self._waiting is None:
                self._changed.wait(timeout)
            taken, self._waiting = self._waiting, None
        return taken

    def _order(self, stamp_ns: int) -> Order:
        if self._last_ns is None or stamp_ns > self._last_ns:
            return Order.ON_TIME
        if stamp_ns == self._last_ns:
            return Order.REPEATED
        return Order.RESTART if self._last_ns - stamp_ns > _JUMP else Order.LATE
