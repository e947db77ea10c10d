# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Frames between threads: the newest wins, and bad stamps do not pass."""

import threading

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.live.frames.latest_frame import LatestFrame, Order
import numpy as np

SECOND = 1_000_000_000  # [ns]
_LIMIT = 60.0  # However slow a machine is [s].


def _frame(stamp_ns: int) -> DepthFrame:
    return DepthFrame(np.ones((3, 4), dtype=np.float32), stamp_ns, 'camera')


def _stamp(latest: LatestFrame) -> int:
    taken = latest.take(0.0)
    assert taken is not None
    return taken.frame.stamp_ns


def test_the_newest_frame_wins_and_the_rest_is_counted():
    latest = LatestFrame()
    for stamp in (1, 2, 3):
        assert latest.put(_frame(stamp), now_ns=10 * stamp) is Order.ON_TIME
    taken = latest.take(0.0)
    assert (taken.frame.stamp_ns, taken.arrived_ns, taken.is_restart) == (3, 30, False)
    assert latest.take(0.0) is None
    latest.put(_frame(4), now_ns=40)
    assert _stamp(latest) == 4
    assert (latest.received, latest.skipped, latest.refused.total()) == (4, 2, 0)


def test_a_stamp_that_repeats_or_comes_late_does_not_pass():
    latest = LatestFrame()
    latest.put(_frame(SECOND), now_ns=0)
    assert latest.put(_frame(SECOND), now_ns=1) is Order.REPEATED
    assert latest.put(_frame(SECOND - 50_000_000), now_ns=2) is Order.LATE
    assert _stamp(latest) == SECOND
    assert latest.refused == {Order.REPEATED: 1, Order.LATE: 1}
    assert latest.skipped == 0


def test_a_clock_that_is_set_back_begins_another_stretch():
    latest = LatestFrame()
    latest.put(_frame(9 * SECOND), now_ns=0)
    assert latest.put(_frame(2 * SECOND), now_ns=1) is Order.RESTART
    # The frame that told of it is replaced; that it was set back is not forgotten.
    assert latest.put(_frame(3 * SECOND), now_ns=2) is Order.ON_TIME
    taken = latest.take(0.0)
    assert taken.frame.stamp_ns == 3 * SECOND
    assert taken.is_restart
    latest.put(_frame(4 * SECOND), now_ns=3)
    assert not latest.take(0.0).is_restart


def test_who_waits_is_woken():
    latest, found = LatestFrame(), []
    waiting = threading.Thread(target=lambda: found.append(latest.take(_LIMIT)))
    waiting.start()
    latest.put(_frame(7), now_ns=0)
    waiting.join(_LIMIT)
    assert found[0].frame.stamp_ns == 7
