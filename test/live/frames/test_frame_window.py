# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The window of frames: newest win, breaks start it anew."""

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.live.frames.frame_window import FrameWindow
import numpy as np

SECOND = 1_000_000_000  # [ns]


def _frame(stamp_ns: int, shape: tuple[int, int] = (3, 4)) -> DepthFrame:
    return DepthFrame(np.ones(shape, dtype=np.float32), stamp_ns, 'camera')


def _filled(*stamps: int, size: int = 3) -> FrameWindow:
    window = FrameWindow(size)
    for stamp in stamps:
        assert window.add(_frame(stamp), now_ns=stamp) is None
    return window


def _stamps(window: FrameWindow) -> list[int]:
    return [frame.stamp_ns for frame in window.frames]


def test_the_newest_frames_are_kept_oldest_first():
    window = _filled(1, 2, 3, 4)
    assert _stamps(window) == [2, 3, 4]
    window.resize(2)
    assert _stamps(window) == [3, 4]
    assert window.newest.stamp_ns == 4


def test_it_is_ripe_when_full_or_after_a_while():
    window = _filled(5 * SECOND, 6 * SECOND)
    assert not window.is_ripe(7 * SECOND, 3 * SECOND)
    assert window.is_ripe(8 * SECOND, 3 * SECOND)
    window.add(_frame(7 * SECOND), now_ns=7 * SECOND)
    assert window.is_ripe(7 * SECOND, 3 * SECOND)
    window.used()
    assert not window.is_ripe(99 * SECOND, 0)


def test_stamps_that_jump_back_start_it_anew():
    window = _filled(5 * SECOND, 6 * SECOND)
    reason = window.add(_frame(2 * SECOND), now_ns=0)
    assert reason == 'stamps jumped back by 4.00 s'
    assert _stamps(window) == [2 * SECOND]
    assert window.fresh_count == 1


def test_stamps_a_little_out_of_order_do_not():
    window = _filled(SECOND)
    assert window.add(_frame(SECOND - 50_000_000), now_ns=0) is None
    assert len(window.frames) == 2


def test_another_image_size_starts_it_anew():
    window = _filled(1, 2)
    assert window.add(_frame(3, (6, 8)), now_ns=3) == 'depth images are 8x6 now'
    assert _stamps(window) == [3]
