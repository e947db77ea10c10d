# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recordings of compressedDepth are read and replayed as those of plain depth are."""

from itertools import count

from diffcal_ros.errors import RecordingError
from diffcal_ros.live.replay.replay_messages import replay_messages, Role
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.names import DEPTH_FRAME, IMAGE_TYPE
from diffcal_ros.recording.topics.ros_messages import deserialize
import numpy as np
import pytest
from support.packed_depth import METRES_PNG, metres_png, packed_message, PNG, png, RVL, rvl

START_NS, PERIOD_NS = 1_628_838_841_927_753_400, 33_333_333
TOPIC = '/depth/image_rect_raw/compressedDepth'


@pytest.fixture
def write_packed(write_bag, depth_images):
    """Write the depth images packed, `spoil` applied to the content of each by its number."""

    def write(kind=PNG, *, spoil=lambda number, content: content, name='packed', keep=False):
        def extra(bag):
            for number, image in enumerate(depth_images):
                if kind == METRES_PNG:
                    content = metres_png(image)
                else:
                    content = (rvl if kind == RVL else png)(millimetres(image))
                stamp = START_NS + number * PERIOD_NS
                packed = packed_message(
                    spoil(number, content), kind, stamp_ns=stamp, frame_id=DEPTH_FRAME
                )
                bag.write(TOPIC, packed, stamp)

        return write_bag(name=name, leave_out=() if keep else ('depth',), extra=extra)

    return write


def millimetres(image):
    return np.nan_to_num(np.rint(image * 1000.0), nan=0.0).astype(np.uint16)


@pytest.mark.parametrize('kind', [PNG, RVL])
def test_millimetres_are_those_of_plain_images(write_packed, write_bag, kind):
    plain = open_recording(write_bag(encoding='16UC1'))
    packed = open_recording(write_packed(kind))
    assert packed.depth_topic == TOPIC
    assert packed.depth_camera == plain.depth_camera
    assert packed.depth_count == 12
    np.testing.assert_array_equal(packed.depth_from_color, plain.depth_from_color)
    for one, other in zip(packed.depth_frames(), plain.depth_frames(), strict=True):
        assert (one.stamp_ns, one.frame_id) == (other.stamp_ns, other.frame_id)
        np.testing.assert_array_equal(one.depth, other.depth)


def test_metres_are_as_near_as_their_steps(write_packed, depth_images):
    frames = list(open_recording(write_packed(METRES_PNG)).depth_frames())
    assert len(frames) == 12
    for frame, image in zip(frames, depth_images, strict=True):
        np.testing.assert_array_equal(np.isnan(frame.depth), np.isnan(image))
        # Steps of inverse depth: z^2 / 10100, towards larger depths.
        off = (frame.depth - image)[np.isfinite(image)]
        assert off.min() > -1e-6
        assert off.max() < 1.01 * 0.6**2 / 10_100


def test_what_is_recorded_twice_is_one_topic(write_packed):
    path = write_packed(keep=True)
    assert open_recording(path).depth_topic == '/depth/image_rect_raw'
    assert open_recording(path, depth_topic=TOPIC).depth_topic == TOPIC


def test_the_plain_name_stands_for_the_packed_images(write_packed):
    found = open_recording(write_packed(), depth_topic='depth/image_rect_raw')
    assert found.depth_topic == TOPIC


def test_damaged_images_are_left_out_and_counted(write_packed):
    path = write_packed(
        RVL, spoil=lambda number, content: content[:-300] if number in (0, 5) else content
    )
    recording = open_recording(path)
    assert len(list(recording.depth_frames())) == 10
    assert sum(recording.skipped.values()) == 2
    assert all('compressed depth image' in reason for reason in recording.skipped)


@pytest.mark.parametrize(
    ('kind', 'words'),
    [(PNG, r'can be read \(a compressed depth image of 9 bytes'), ('jpeg', "format is 'jpeg'")],
)
def test_what_cannot_be_read_at_all_is_told(write_packed, kind, words):
    path = write_packed(kind, spoil=lambda number, content: content[:9])
    with pytest.raises(RecordingError, match=f'none of the first images .*{words}'):
        open_recording(path)


def test_a_packed_recording_of_another_size_than_its_camera_is_refused(write_packed):
    path = write_packed(PNG, spoil=lambda number, content: png(np.ones((20, 30), np.uint16)))
    with pytest.raises(RecordingError, match=r'is for 48x36 pixels, but .* has 30x20'):
        open_recording(path)


def test_a_replay_unpacks_and_tells_what_it_leaves_out(write_packed, depth_images):
    path = write_packed(spoil=lambda number, content: content[:40] if number == 3 else content)
    rounds, told = count(), []
    sent = replay_messages(open_recording(path), lambda: next(rounds) < 1, told.append)
    images = [deserialize(one.data, IMAGE_TYPE) for one in sent if one.role is Role.DEPTH]
    assert len(images) == 2 * 11
    assert {image.encoding for image in images} == {'16UC1'}
    first = images[0].data.view('<u2').reshape(36, 48)
    np.testing.assert_array_equal(first, millimetres(depth_images[0]))
    stamps = [image.header.stamp.sec * 10**9 + image.header.stamp.nanosec for image in images]
    assert (np.diff(stamps) > 0).all()
    assert len(told) == 2
    assert all(TOPIC in reason for reason in told)
