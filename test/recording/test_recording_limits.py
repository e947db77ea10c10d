# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recordings that ask for more than there is, or print more than one reads."""

from dataclasses import replace
import tracemalloc
import zlib

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.color_frame import decode_compressed
from diffcal_ros.recording.topics.ros_messages import camera_info_message, image_message, message
import lz4.frame
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk, DataEnd, Footer, Header
from mcap.writer import CompressionType
import numpy as np
from PIL import Image
import pytest
import zstandard

START_NS = 1_628_838_841_927_753_400
PERIOD_NS = 33_333_333
MAGIC = b'\x89MCAP0\r\n'
_ZEROS = 64 << 20


def file_of(records, path):
    content = MAGIC
    for record in (Header('ros2', 'x'), *records, DataEnd(0), Footer(0, 0, 0)):
        builder = RecordBuilder()
        record.write(builder)
        content += builder.end()
    path.write_bytes(content + MAGIC)
    return path


def zeros(compression):
    content = bytes(_ZEROS)
    if compression == 'lz4':
        return lz4.frame.compress(content)
    # The frame tells its size, or does not.
    return zstandard.ZstdCompressor(write_content_size='+' in compression).compress(content)


@pytest.mark.parametrize('compression', ['zstd', 'zstd+size', 'lz4'])
@pytest.mark.parametrize('told', [0, 1000])
def test_a_chunk_yields_no_more_than_it_tells(tmp_path, compression, told):
    chunk = Chunk(compression.partition('+')[0], zeros(compression), 0, 0, 0, told)
    path = file_of([chunk], tmp_path / 'bomb.mcap')
    assert path.stat().st_size < _ZEROS / 100
    tracemalloc.start()
    with pytest.raises(RecordingError, match='is not of the size that it tells'):
        open_recording(path)
    assert tracemalloc.get_traced_memory()[1] < _ZEROS / 4
    tracemalloc.stop()


def test_a_chunk_that_would_fill_the_memory_is_refused(tmp_path):
    chunk = Chunk('zstd', zstandard.compress(bytes(9000)), 0, 0, 0, 6 << 30)
    path = file_of([chunk], tmp_path / 'bomb.mcap')
    with pytest.raises(
        RecordingError, match='would unpack to 6144 MB, and at most 512 MB are unpacked'
    ):
        open_recording(path)
    with pytest.raises(RecordingError, match=r'bomb.mcap is damaged, and no message stands'):
        open_recording(path, allow_truncated=True)


def test_an_unknown_compression_is_named(tmp_path):
    path = file_of([Chunk('br\x1b[31m', b'x', 0, 0, zlib.crc32(b'x'), 1)], tmp_path / 'x.mcap')
    with pytest.raises(RecordingError, match=r"compressed by 'br\\+x1b\[31m': zstd and lz4 are"):
        open_recording(path)


@pytest.mark.parametrize('reach', [3, 5, 11, 13])
def test_a_message_index_that_is_cut_short(write_bag, rewrite, reach):
    file = rewrite(write_bag(), chunk_size=20_000, enable_crcs=False)
    content = bytearray(file.read_bytes())
    # A message index of one entry: its length is spoilt.
    place = content.index(b'\x07\x16' + bytes(7))
    content[place + 1] = reach
    file.write_bytes(content)
    with pytest.raises(RecordingError, match='is corrupt, its records cannot be read'):
        open_recording(file)
    assert open_recording(file, allow_truncated=True).depth_count == 12


def test_many_topics_are_counted_and_not_listed(write_bag):
    def write(bag):
        for number in range(200):
            bag.write(f'/t{number}', message('std_msgs/msg/Float64', data=0.0), START_NS)

    with pytest.raises(RecordingError, match=r'no depth topic, only .* and \d+ more: ') as caught:
        open_recording(write_bag(leave_out=('depth',), extra=write))
    assert len(str(caught.value)) < 1500


@pytest.mark.parametrize('topic', ['/depth/image_rect_raw', '/other'])
def test_escape_codes_and_endless_names_are_not_printed(write_bag, topic):
    evil = '\x1b[2J\x07' + 'x' * 100_000

    def write(bag):
        image = image_message(
            np.ones((36, 48), np.float32), encoding=evil, stamp_ns=START_NS, frame_id=evil
        )
        bag.write(topic, image, START_NS)
        bag.write('/\x1b[31m' + 'y' * 50_000, image, START_NS)

    with pytest.raises(RecordingError) as caught:
        open_recording(write_bag(leave_out=('depth',), extra=write))
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 900


def test_reasons_of_skipped_frames_are_plain_too(write_bag):
    evil = '\x1b[2J' + 'x' * 100_000

    def write(bag):
        image = image_message(
            np.ones((36, 48), np.float32), encoding=evil, stamp_ns=START_NS, frame_id='d'
        )
        bag.write('/depth/image_rect_raw', image, START_NS + 20 * PERIOD_NS)

    recording = open_recording(write_bag(extra=write))
    assert len(list(recording.depth_frames())) == 12
    (reason,) = recording.skipped
    assert reason.isprintable()
    assert len(reason) < 300


def changing_info(camera, **changes):
    """Write infos that change after the sixth image."""

    def write(bag):
        for number in range(12):
            now = camera if number < 6 else replace(camera, **changes)
            stamp = START_NS + number * PERIOD_NS
            info = camera_info_message(now, stamp_ns=stamp, frame_id='d')
            bag.write('/depth/camera_info', info, stamp)

    return write


def test_intrinsics_that_change_are_refused(write_bag, depth_camera):
    zoomed = changing_info(depth_camera, fx=45.0)
    recording = open_recording(write_bag(leave_out=('depth_camera',), extra=zoomed))
    frames = recording.depth_frames()
    for _ in range(6):
        next(frames)
    match = r'/depth/camera_info changes within the recording, from .*fx=41.5.* to .*fx=45, '
    with pytest.raises(RecordingError, match=match):
        next(frames)
    with pytest.raises(RecordingError, match=match):
        list(recording.depth_frames(3))
    with pytest.raises(RecordingError, match=match):
        list(recording.depth_frames_at([2, 9]))


def test_digits_that_are_rounded_are_no_change(write_bag, depth_camera):
    rounded = changing_info(depth_camera, fx=41.5004, cx=22.7501)
    recording = open_recording(write_bag(leave_out=('depth_camera',), extra=rounded))
    assert len(list(recording.depth_frames())) == 12


def test_the_camera_of_the_scene_does_not_change(write_bag, depth_camera):
    zoomed = changing_info(depth_camera, fx=45.0)
    path = write_bag(leave_out=('depth_camera',), extra=zoomed)
    recording = open_recording(path, depth_camera=depth_camera)
    assert len(list(recording.depth_frames())) == 12


def test_a_camera_info_that_came_once_holds_for_all(write_bag, rewrite, depth_camera):
    def write(bag):
        info = camera_info_message(depth_camera, stamp_ns=START_NS, frame_id='d')
        bag.write('/depth/camera_info', info, START_NS)

    path = write_bag(leave_out=('depth_camera',), extra=write)
    file = rewrite(path, chunk_size=20_000, compression=CompressionType.NONE)
    assert len(list(open_recording(file).depth_frames())) == 12


def add_color_info(**fields):
    def write(bag):
        camera = PinholeCamera(32, 24, 30.0, 29.0, 15.25, 12.5, (-0.1, 0.02, 0.001, 0.0, 0.0))
        info = camera_info_message(camera, stamp_ns=START_NS, frame_id='c')
        for name, value in fields.items():
            setattr(info, name, value)
        bag.write('/color/camera_info', info, START_NS)

    return write


def add_color_image(color_images, info):
    def write(bag):
        image = image_message(color_images[0], encoding='bgr8', stamp_ns=START_NS, frame_id='c')
        bag.write('/color/image_raw', image, START_NS)
        info(bag)

    return write


@pytest.mark.parametrize(
    ('fields', 'problem'),
    [
        ({'distortion_model': 'equidistant'}, "has the lens model 'equidistant'"),
        ({'k': np.zeros(9), 'p': np.zeros(12)}, 'focal length is fx=0, fy=0'),
        ({'width': 64}, 'is for 64x24 pixels, but /color/image_raw has 32x24'),
        ({'d': np.array([0.1, 0.0, 0.0])}, 'has 3 distortion coefficients: a lens model has 4, '),
        ({'k': np.diag([1e-6, 1e-6, 1.0]).ravel()}, 'focal length is fx=1e-06, fy=1e-06 px for'),
        ({'k': np.full(9, np.nan)}, 'camera intrinsics hold NaN or Inf'),
    ],
)
def test_the_true_reason_is_told_where_the_colour_camera_is_unusable(
    write_bag, color_images, fields, problem
):
    extra = add_color_image(color_images, add_color_info(**fields))
    recording = open_recording(write_bag(leave_out=('color',), extra=extra))
    assert recording.color_camera is None
    assert problem in recording.color_problem
    assert recording.notes == (recording.color_problem,)


def test_bad_frames_of_one_time_are_counted_each(write_bag):
    def write(bag):
        for _ in range(3):
            image = image_message(
                np.ones((5, 7), np.float32), encoding='32FC1', stamp_ns=START_NS, frame_id='d'
            )
            bag.write('/depth/image_rect_raw', image, START_NS)

    recording = open_recording(write_bag(extra=write))
    assert len(list(recording.depth_frames())) == 12
    assert sum(recording.skipped.values()) == 3


def test_compressed_images_that_claim_too_many_pixels_are_refused(tmp_path):
    Image.new('1', (10_000, 7_000)).save(tmp_path / 'huge.png')
    content = (tmp_path / 'huge.png').read_bytes()
    with pytest.raises(ValueError, match='it would have 10000x7000 pixels'):
        decode_compressed(content)
    for end in range(0, len(content), 700):
        with pytest.raises(ValueError, match='no JPEG or PNG that can be read'):
            decode_compressed(content[:end])
