# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A live stream cut into swings."""

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.live.frames.swing_window import Stage, SwingWindow
import numpy as np
import pytest

PERIOD = 33_333_333  # [ns]
START = 1_700_000_000_000_000_000  # [ns]
DURATION = 1.0  # [s]


class Camera:
    """Films a square that lies at some column before a wall."""

    def __init__(self) -> None:
        self.window = SwingWindow(DURATION)
        self.stamp_ns = START
        self._random = np.random.default_rng(2)

    def shoot(self, columns, shape=(60, 80)) -> None:
        for column in columns:
            self.stamp_ns += PERIOD
            depth = self._random.normal(0.9, 2e-4, shape).astype(np.float32)
            depth[20:40, column : column + 20] -= 0.3
            self.window.add(DepthFrame(depth, self.stamp_ns, 'camera'))

    def rest(self, seconds: float, column: int = 5) -> None:
        self.shoot([column] * round(seconds * 30))

    def swing(self, seconds: float = DURATION) -> None:
        times = np.arange(1, round(seconds * 30) + 1) / 30.0
        self.shoot(np.clip(5 + 40 * (1 - np.cos(6.0 * times)) / 2, 5, 55).astype(int))


@pytest.fixture
def camera():
    return Camera()


def test_rest_and_then_movement_is_a_swing_with_its_lead(camera):
    camera.rest(0.3)
    assert camera.window.stage is Stage.UNSETTLED
    camera.rest(0.3)
    assert camera.window.stage is Stage.RESTING
    camera.swing()
    swing = camera.window.take()
    assert camera.window.take() is None, 'once'
    assert camera.window.seen == 1
    stamps = np.array([frame.stamp_ns for frame in swing.frames])
    assert np.all(np.diff(stamps) == PERIOD)
    assert (stamps[-1] - stamps[0]) / 1e9 == pytest.approx(DURATION, abs=0.04)
    # It moves 4 px within the third frame; before that a quarter of a second is at rest.
    assert 0.2 < swing.onset < 0.4
    first, onset = swing.frames[0].depth, round(swing.onset * 1e9 / PERIOD)
    assert np.abs(swing.frames[onset - 1].depth - first)[20:40, 10:20].max() < 0.01


def test_the_newest_swing_wins_and_the_other_is_counted(camera):
    for _ in range(3):
        camera.rest(0.6)
        camera.swing(1.1)
    assert camera.window.seen == 3
    assert camera.window.skipped == 2
    assert camera.window.skipped_frames == pytest.approx(60, abs=4)
    newest = camera.window.take()
    assert newest.frames[-1].stamp_ns > camera.stamp_ns - 0.5e9


def test_a_body_that_never_rests_gives_no_swing(camera):
    camera.swing(5.0)
    assert camera.window.stage is Stage.UNSETTLED
    assert camera.window.seconds == pytest.approx(5.0, abs=0.1)
    assert camera.window.take() is None


def test_a_single_strange_frame_is_no_movement(camera):
    camera.rest(0.6)
    camera.shoot([40])
    camera.rest(0.2)
    assert camera.window.stage is Stage.RESTING


def test_what_is_kept_while_it_rests_is_bounded(camera):
    camera.rest(5.0)
    camera.swing()
    swing = camera.window.take()
    assert len(swing.frames) < 1.1 * DURATION * 30


def test_stamps_that_repeat_are_refused_and_jumps_begin_anew(camera):
    camera.rest(0.6)
    camera.stamp_ns -= PERIOD
    camera.shoot([5])
    assert camera.window.refused == 1
    assert camera.window.stage is Stage.RESTING
    for jump in (-60_000_000_000, 2_000_000_000):
        camera.stamp_ns += jump
        camera.shoot([5])
        assert camera.window.stage is Stage.UNSETTLED
        camera.rest(0.6)
        assert camera.window.stage is Stage.RESTING
    camera.shoot([5], shape=(61, 80))
    assert camera.window.stage is Stage.UNSETTLED


def test_a_break_in_mid_swing_is_not_bridged(camera):
    camera.rest(0.6)
    camera.swing(0.4)
    assert camera.window.stage is Stage.MOVING
    camera.stamp_ns += 3_000_000_000
    camera.swing(0.9)
    assert camera.window.take() is None
