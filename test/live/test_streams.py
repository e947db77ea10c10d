# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is counted about streams, and which images pass."""

from dataclasses import replace
import struct

from diffcal_ros.live.frames.frame_gate import FrameGate, ImageFacts
from diffcal_ros.live.health import Level
from diffcal_ros.live.replay.cdr_stamp import move_stamp, read_stamp
from diffcal_ros.live.stream_meter import StreamMeter
from diffcal_ros.recording.topics.ros_messages import (
    deserialize,
    image_message,
    serialize,
    stamp_ns_of,
)
import numpy as np
import pytest

SECOND = 1_000_000_000  # [ns]
GOOD = ImageFacts('16UC1', 64, 48, 128, 128 * 48, 7 * SECOND, 'camera')


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'encoding': 'rgb8'}, "encoding is 'rgb8'"),
        ({'byte_count': 100}, 'cut off'),
        ({'step': 64}, 'step is 64 bytes, 64 16UC1 pixels take 128'),
        ({'width': 32}, 'image of 32x48, camera_info says 64x48'),
        ({'frame_id': ''}, 'frame_id is empty'),
        ({'stamp_ns': 0}, 'stamp is zero'),
        ({'stamp_ns': 5 * SECOND}, 'lies before the last one'),
    ],
)
def test_a_bad_image_is_kept_back_and_counted(changes, reason):
    gate = FrameGate('depth', is_depth=True)
    gate.camera_size = (64, 48)
    assert gate.check(GOOD) is None
    assert reason in gate.check(replace(GOOD, **changes))
    assert (gate.passed, gate.bad.total()) == (1, 1)


def test_a_clock_that_was_set_back_costs_one_image():
    gate = FrameGate('depth', is_depth=True)
    gate.check(GOOD)
    early = [replace(GOOD, stamp_ns=SECOND + number) for number in range(3)]
    assert [gate.check(facts) is None for facts in early] == [False, True, True]


def test_colour_is_no_depth_and_depth_no_colour():
    assert FrameGate('color', is_depth=False).check(GOOD)
    picture = replace(GOOD, encoding='bgr8', step=192, byte_count=192 * 48)
    assert FrameGate('color', is_depth=False).check(picture) is None


def test_the_meter_gives_rate_delay_and_age():
    meter = StreamMeter()
    for number in range(61):
        meter.arrived(number * SECOND // 30, number * SECOND // 30, delay_ns=number * 1_000_000)
    now = 2 * SECOND
    assert meter.rate(now) == pytest.approx(30.0, rel=1e-6)
    assert meter.rate(now + 10 * SECOND) == 0.0
    assert meter.delay_ms(50.0) == pytest.approx(30.0)
    figures = meter.figures(now, 2 * SECOND + 250_000_000)
    assert figures['stamp age [s]'] == '0.250'
    assert figures['messages received'] == '61'


def test_what_went_wrong_is_told_for_ten_seconds():
    meter = StreamMeter()
    for number in range(31):
        meter.arrived(number * SECOND // 30, number * SECOND // 30)
    assert meter.trouble(SECOND, 'images') is None
    meter.lose(SECOND, 100)
    meter.lose(SECOND + 1, 48)
    level, words = meter.trouble(2 * SECOND, 'images')
    assert level is Level.WARN
    assert '148 images were lost' in words
    for number in range(30, 361):
        meter.arrived(number * SECOND // 30, number * SECOND // 30)
    assert meter.trouble(12 * SECOND, 'images') is None
    assert meter.lost == 148, 'the sum stays'


@pytest.mark.parametrize(
    ('period', 'quiet', 'level'),
    [
        (0.033, 2.5, None),
        (0.033, 4.0, Level.WARN),
        (0.033, 9.0, Level.ERROR),
        # A camera that sends one image in two seconds.
        (2.0, 9.0, None),
        (2.0, 11.0, Level.WARN),
        (2.0, 31.0, Level.ERROR),
    ],
)
def test_a_camera_that_stopped_is_told(period, quiet, level):
    meter = StreamMeter()
    assert meter.trouble(99 * SECOND, 'images') is None, 'it has not begun'
    last = [round(number * period * SECOND) for number in range(5)]
    for time in last:
        meter.arrived(time, time)
    told = meter.trouble(last[-1] + round(quiet * SECOND), 'images')
    assert (told and told[0]) == level
    assert f'no images for {quiet:.0f} s' in (told[1] if told else f'no images for {quiet:.0f} s')


def test_a_stamp_is_moved_and_nothing_else():
    pixels = np.arange(12, dtype=np.uint16).reshape(3, 4)
    stamp = 1_700_000_000_999_999_999
    image = image_message(pixels, encoding='16UC1', stamp_ns=stamp, frame_id='camera')
    data = serialize(image)
    assert read_stamp(data) == stamp
    moved = deserialize(move_stamp(data, 2), 'sensor_msgs/msg/Image')
    assert stamp_ns_of(moved) == stamp + 2
    assert moved.header.frame_id == 'camera'
    np.testing.assert_array_equal(moved.data, image.data)
    assert move_stamp(data, 0) == data


def test_both_byte_orders_of_cdr_are_read():
    body = struct.pack('>iI', 12, 34)
    assert read_stamp(b'\x00\x00\x00\x00' + body) == 12 * SECOND + 34
    assert read_stamp(move_stamp(b'\x00\x00\x00\x00' + body, SECOND)) == 13 * SECOND + 34
    with pytest.raises(ValueError, match='holds no header'):
        read_stamp(b'\x00\x01\x00\x00')
