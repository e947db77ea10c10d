# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

import hashlib
import shutil

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.ros_messages import image_message, message, transform_message
from mcap.reader import make_reader
from mcap.writer import IndexType, Writer
import numpy as np
from PIL import Image
import pytest
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import get_typestore, Stores

START_NS = 1_628_838_841_927_753_400
PERIOD_NS = 33_333_333


def test_recording_says_what_it_holds(write_bag, depth_camera, color_camera, depth_from_color):
    path = write_bag()
    recording = open_recording(path)
    assert recording.path == path
    assert recording.depth_topic == '/depth/image_rect_raw'
    assert recording.color_topic == '/color/image_raw'
    assert recording.depth_camera == depth_camera
    assert recording.color_camera == color_camera
    assert recording.depth_frame_id == 'camera_depth_optical_frame'
    np.testing.assert_allclose(recording.depth_from_color, depth_from_color, atol=1e-12)
    assert recording.depth_count == recording.color_count == 12
    assert recording.topic_counts['/tf_static'] == 1
    assert recording.saved_count is None
    assert recording.notes == ()
    assert recording.first_stamp_ns == START_NS
    assert recording.last_stamp_ns == START_NS + 11 * PERIOD_NS
    file = next(path.glob('*.mcap'))
    assert recording.sha256 == hashlib.sha256(file.read_bytes()).hexdigest()


@pytest.mark.parametrize('compression', ['zstd', 'lz4', 'none'])
def test_frames_come_back_as_written(write_bag, depth_images, color_images, compression):
    recording = open_recording(write_bag(compression=compression))
    depth, color = list(recording.depth_frames()), list(recording.color_frames())
    np.testing.assert_array_equal([frame.depth for frame in depth], depth_images)
    np.testing.assert_array_equal([frame.image for frame in color], color_images)
    assert [frame.stamp_ns for frame in depth] == [START_NS + k * PERIOD_NS for k in range(12)]
    assert depth[0].frame_id == 'camera_depth_optical_frame'
    assert color[0].frame_id == 'camera_color_optical_frame'
    assert not recording.skipped


def test_millimetres_come_back_in_metres(write_bag, depth_images):
    frames = list(open_recording(write_bag(encoding='16UC1')).depth_frames())
    np.testing.assert_allclose([frame.depth for frame in frames], depth_images, atol=0.5001e-3)


@pytest.mark.parametrize('limit', [1, 3, 5, 12, 40])
def test_limited_frames_are_evenly_spaced(write_bag, limit):
    recording = open_recording(write_bag())
    stamps = np.array([frame.stamp_ns for frame in recording.depth_frames(limit)])
    numbers = (stamps - START_NS) // PERIOD_NS
    assert len(numbers) == min(limit, 12)
    gaps = np.diff(numbers)
    assert gaps.size == 0 or gaps.min() >= 1
    assert gaps.size == 0 or gaps.max() - gaps.min() <= 1
    assert abs(numbers.mean() - 5.5) <= 1.0


def test_bare_file_and_missing_metadata_give_the_same(write_bag, tmp_path, depth_images):
    path = write_bag()
    file = next(path.glob('*.mcap'))
    bare = shutil.copy(file, tmp_path / 'alone.mcap')
    (path / 'metadata.yaml').unlink()
    for place in (bare, path):
        frames = list(open_recording(place).depth_frames())
        np.testing.assert_array_equal([frame.depth for frame in frames], depth_images)


def test_split_bag_is_read_in_order(write_bag, depth_images):
    path = write_bag(frames=depth_images[:6])
    later = write_bag(name='later', frames=depth_images[6:])
    (path / 'metadata.yaml').unlink()
    # Sorted by number, not by letter.
    (path / 'bag_0.mcap').rename(path / 'bag_9.mcap')
    shutil.copy(later / 'later_0.mcap', path / 'bag_10.mcap')
    recording = open_recording(path)
    np.testing.assert_array_equal(
        [frame.depth for frame in recording.depth_frames()], depth_images
    )
    both = (path / 'bag_9.mcap').read_bytes() + (path / 'bag_10.mcap').read_bytes()
    assert recording.sha256 == hashlib.sha256(both).hexdigest()


@pytest.mark.parametrize(
    'options',
    [
        {'index_types': IndexType.NONE},
        {'use_chunking': False},
        {'use_statistics': False, 'repeat_channels': False, 'repeat_schemas': False},
        {'enable_crcs': False},
    ],
)
def test_files_without_index_chunks_or_summary_are_read(write_bag, rewrite, depth_images, options):
    rewritten = rewrite(write_bag(), **options)
    recording = open_recording(rewritten)
    np.testing.assert_array_equal(
        [frame.depth for frame in recording.depth_frames()], depth_images
    )
    assert recording.color_count == 12


def test_all_messages_come_in_the_order_of_recording(write_bag):
    recording = open_recording(write_bag())
    raw = list(recording.messages.read_all())
    assert len(raw) == sum(recording.topic_counts.values())
    assert [item.log_time_ns for item in raw] == sorted(item.log_time_ns for item in raw)
    chosen = recording.messages.read_all(['/depth/image_rect_raw', '/color/image_raw'])
    assert {item.topic for item in chosen} == {'/depth/image_rect_raw', '/color/image_raw'}


def add_depth(pixels, *, topic='/depth/image_rect_raw', encoding='32FC1', number=20, **fields):
    """Make a function that writes one more depth image with some fields changed."""

    def write(bag):
        stamp = START_NS + number * PERIOD_NS
        image = image_message(pixels, encoding=encoding, stamp_ns=stamp, frame_id='d')
        for name, value in fields.items():
            setattr(image, name, value)
        bag.write(topic, image, stamp)

    return write


def both(*writers):
    def write(bag):
        for writer in writers:
            writer(bag)

    return write


def test_big_endian_and_padded_rows(write_bag):
    values = np.arange(1, 36 * 48 + 1, dtype=np.uint16).reshape(36, 48)
    padded = np.zeros((36, 50), '>u2')
    padded[:, :48] = values
    path = write_bag(
        leave_out=('depth',),
        extra=add_depth(
            values, encoding='16UC1', is_bigendian=1, step=100, data=padded.view(np.uint8).ravel()
        ),
    )
    (frame,) = open_recording(path).depth_frames()
    np.testing.assert_allclose(frame.depth, values * 0.001, rtol=1e-6)


def test_bad_frames_are_skipped_and_counted(write_bag, depth_images):
    path = write_bag(
        extra=both(
            add_depth(np.ones((5, 7), np.float32), number=20),
            add_depth(np.full((36, 48), np.nan, np.float32), number=21),
            add_depth(np.ones((36, 48), np.float32), number=22, encoding='64FC1'),
            add_depth(np.ones((36, 48), np.float32), number=23, data=np.zeros(9, np.uint8)),
        )
    )
    recording = open_recording(path)
    for _ in range(2):
        assert len(list(recording.depth_frames())) == 12
        assert sum(recording.skipped.values()) == 4
    told = ' | '.join(recording.skipped)
    assert 'image of 7x5, camera_info says 48x36' in told
    assert 'no pixel holds a depth' in told
    assert "encoding is '64FC1'" in told
    assert 'the message is cut off' in told


def test_bad_frame_gives_its_place_to_a_neighbour(write_bag, depth_images):
    spoilt = depth_images.copy()
    spoilt[[5, 6]] = np.nan
    recording = open_recording(write_bag(frames=spoilt))
    (frame,) = recording.depth_frames(1)
    assert (frame.stamp_ns - START_NS) // PERIOD_NS in (4, 7)


def test_nan_inf_negative_and_zero_are_invalid(write_bag):
    image = np.full((36, 48), 0.5, np.float32)
    image[0, :4] = [np.nan, np.inf, -0.1, 0.0]
    (frame,) = open_recording(write_bag(frames=image[None])).depth_frames()
    assert np.isnan(frame.depth[0, :4]).all()
    assert np.isfinite(frame.depth).sum() == 36 * 48 - 4


@pytest.mark.parametrize(
    ('encoding', 'channels'),
    [
        ('rgb8', [2, 1, 0]),
        ('bgra8', [0, 1, 2, 0]),
        ('rgba8', [2, 1, 0, 0]),
        ('mono8', [1]),
    ],
)
def test_colour_encodings(write_bag, color_images, encoding, channels):
    pixels = color_images[0][..., channels]
    pixels = pixels[..., 0] if encoding == 'mono8' else pixels

    def write(bag):
        bag.write(
            '/color/image_raw',
            image_message(pixels, encoding=encoding, stamp_ns=START_NS, frame_id='c'),
            START_NS,
        )

    (frame,) = open_recording(write_bag(leave_out=('color',), extra=write)).color_frames()
    expected = color_images[0] if encoding != 'mono8' else np.repeat(pixels[..., None], 3, axis=2)
    np.testing.assert_array_equal(frame.image, expected)


def test_compressed_colour(write_bag, color_images, color_camera, tmp_path):
    Image.fromarray(color_images[0][..., ::-1]).save(tmp_path / 'image.png')
    content = np.frombuffer((tmp_path / 'image.png').read_bytes(), np.uint8)

    def write(bag):
        for number, data in enumerate((content, content[:50])):
            stamped = transform_message(np.eye(4), parent='c', child='d', stamp_ns=START_NS)
            compressed = message(
                'sensor_msgs/msg/CompressedImage',
                header=stamped.header,
                format='png',
                data=data,
            )
            bag.write('/color/image_raw/compressed', compressed, START_NS + number)
        bag.write_color_camera(color_camera, stamp_ns=START_NS, frame_id='c')

    recording = open_recording(write_bag(leave_out=('color',), extra=write))
    assert recording.color_camera == color_camera
    (frame,) = recording.color_frames()
    np.testing.assert_array_equal(frame.image, color_images[0])
    assert 'no JPEG or PNG that can be read' in next(iter(recording.skipped))


def test_chosen_depth_topic_and_given_cameras(write_bag, depth_camera, depth_images):
    path = write_bag(
        leave_out=('depth_camera',),
        extra=add_depth(depth_images[3] * 2.0, topic='/aligned/image_raw'),
    )
    recording = open_recording(path, depth_topic='aligned/image_raw', depth_camera=depth_camera)
    (frame,) = recording.depth_frames()
    np.testing.assert_allclose(frame.depth, depth_images[3] * 2.0)


def test_recording_without_colour(write_bag):
    recording = open_recording(write_bag(leave_out=('color',)))
    assert recording.color_topic is None
    assert recording.depth_from_color is None
    assert list(recording.color_frames()) == []


def test_written_frames_keep_their_own_copy(write_bag):
    first, second, *_ = open_recording(write_bag()).depth_frames()
    assert isinstance(first, DepthFrame)
    first.depth[:] = 0.0
    assert np.nanmax(second.depth) > 0.0


@pytest.mark.parametrize('options', [{}, {'enable_crcs': False}, {'use_chunking': False}])
def test_what_else_a_file_may_hold_is_passed_over(write_bag, tmp_path, options):
    file = tmp_path / 'more.mcap'
    with next(write_bag().glob('*.mcap')).open('rb') as source, file.open('wb') as target:
        writer = Writer(target, **options)
        writer.start('ros2')
        writer.add_metadata('rosbag2', {'serialized_metadata': 'x: 1'})
        writer.add_attachment(1, 2, 'notes.txt', 'text/plain', b'hello')
        # A channel without a schema, and one without messages.
        writer.register_channel('/idle', 'cdr', 0)
        channels = {'/bare': writer.register_channel('/bare', 'json', 0)}
        writer.add_message(channels['/bare'], START_NS, b'{}', START_NS)
        for schema, channel, record in make_reader(source).iter_messages():
            if channel.topic not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.topic] = writer.register_channel(channel.topic, 'cdr', number)
            writer.add_message(
                channels[channel.topic], record.log_time, record.data, record.publish_time
            )
        writer.finish()
    for is_tolerant in (False, True):
        recording = open_recording(file, allow_truncated=is_tolerant)
        assert recording.topic_counts['/bare'] == 1
        assert len(list(recording.depth_frames())) == 12
        assert recording.notes == ()


def test_bags_of_another_writer_are_read(write_bag, tmp_path, depth_images):
    types = get_typestore(Stores.ROS2_JAZZY)
    path = tmp_path / 'rosbags'
    with RosbagsWriter(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {}
        for raw in open_recording(write_bag()).messages.read_all():
            if raw.topic not in connections:
                connections[raw.topic] = writer.add_connection(
                    raw.topic, raw.type_name, typestore=types
                )
            writer.write(connections[raw.topic], raw.log_time_ns, raw.data)
        # Described last: its chunk holds no message.
        writer.add_connection('/idle', 'std_msgs/msg/Float64', typestore=types)
    for is_tolerant in (False, True):
        recording = open_recording(path, allow_truncated=is_tolerant)
        np.testing.assert_array_equal(
            [frame.depth for frame in recording.depth_frames()], depth_images
        )
        assert recording.notes == ()
