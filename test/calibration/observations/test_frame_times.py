# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Stamps of a motion's frames, and what is said when they are no times."""

from dataclasses import replace

from diffcal_ros.calibration.observations.frame_times import chosen_frames, frame_times, FrameTime
from diffcal_ros.errors import RecordingError
from diffcal_ros.scene.model import MotionSetup, Quantity
import numpy as np
import pytest

START = 1_700_000_000_000_000_000
PERIOD = 33_333_333
MOTION = MotionSetup(('ledge',), Quantity(0.1, 0.0, 0.3), hold_out=0)


def stamps(count: int = 20) -> list[int | None]:
    return [START + number * PERIOD for number in range(count)]


def test_times_count_from_the_first_frame() -> None:
    frames, notes = frame_times(stamps(5))
    assert [frame.index for frame in frames] == [0, 1, 2, 3, 4]
    assert [frame.time for frame in frames] == pytest.approx(np.arange(5) * PERIOD * 1e-9)
    assert notes == []


def test_an_unreadable_frame_keeps_the_places_of_the_others() -> None:
    given = stamps(6)
    given[2] = None
    assert [frame.index for frame in frame_times(given)[0]] == [0, 1, 3, 4, 5]


def test_a_few_stamps_that_jump_back_or_repeat_are_left_out() -> None:
    given = stamps()
    given[5], given[9] = START, given[8]
    frames, (note,) = frame_times(given)
    assert [frame.index for frame in frames] == [n for n in range(20) if n not in (5, 9)]
    assert note == (
        '1 stamps jump back and 1 stamps repeat the one before: these frames are left out'
    )


def test_a_clock_that_starts_anew_is_refused() -> None:
    with pytest.raises(RecordingError, match='of 40 depth frames 20 stamps jump back'):
        frame_times([*stamps(), *(stamp - PERIOD // 2 for stamp in stamps() if stamp)])


def test_a_clock_that_stands_still_is_refused() -> None:
    with pytest.raises(RecordingError, match='all 20 depth frames carry the same stamp'):
        frame_times([START] * 20)


def test_too_few_frames_are_refused() -> None:
    with pytest.raises(RecordingError, match='there are 3 depth frames: a motion needs at least'):
        frame_times(stamps(3))


def test_frames_after_a_gap_of_seconds_are_left_out() -> None:
    given = [*stamps(12), *(stamp + 3_000_000_000 for stamp in stamps(20)[12:] if stamp)]
    frames, (note,) = frame_times(given)
    assert len(frames) == 12
    assert note == ('no frame for 3.0 s after 0.37 s: the 8 frames after this gap are left out')


def test_a_release_after_the_last_frame_is_refused() -> None:
    frames, _ = frame_times(stamps(4))
    with pytest.raises(RecordingError, match=r'end 0\.1 s after .* release is expected at 0\.1 s'):
        chosen_frames(frames, MOTION)


def test_frames_are_chosen_evenly_and_some_are_held_out() -> None:
    frames, _ = frame_times(stamps(61))
    chosen = chosen_frames(frames, replace(MOTION, most_frames=11, hold_out=5, duration=1.4))
    assert {int(step) for step in np.diff([frame.index for frame in chosen])} <= {4, 5}
    assert max(frame.time for frame in chosen) <= 1.4
    assert [number for number, frame in enumerate(chosen) if frame.is_held_out] == [2, 7]
    assert len(chosen) == 11


def test_all_frames_are_used_where_there_are_few() -> None:
    frames = [FrameTime(place, 0.1 * place) for place in range(7)]
    assert chosen_frames(frames, MOTION) == frames
