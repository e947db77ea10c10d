# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a recording is said in one sentence; nothing wrong passes silently."""

from dataclasses import replace
import shutil

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.ros_messages import camera_info_message, image_message
import numpy as np
import pytest

STAMP = 1_700_000_000_000_000_000


@pytest.fixture
def mcap(write_bag, tmp_path):
    """One bare file, so that only its own bytes count."""
    return shutil.copy(next(write_bag().glob('*.mcap')), tmp_path / 'alone.mcap')


def add_image(topic, pixels, encoding):
    def write(bag):
        image = image_message(pixels, encoding=encoding, stamp_ns=STAMP, frame_id='d')
        bag.write(topic, image, STAMP)

    return write


def add_info(camera, **fields):
    def write(bag):
        info = camera_info_message(camera, stamp_ns=STAMP, frame_id='d')
        for name, value in fields.items():
            setattr(info, name, value)
        bag.write('/depth/camera_info', info, STAMP)

    return write


def test_missing_path(tmp_path):
    with pytest.raises(RecordingError, match=r'there is no recording .*gone'):
        open_recording(tmp_path / 'gone')


def test_empty_file(tmp_path):
    (tmp_path / 'empty.mcap').touch()
    with pytest.raises(RecordingError, match=r'empty.mcap is empty: nothing was recorded'):
        open_recording(tmp_path / 'empty.mcap')


def test_empty_directory(tmp_path):
    with pytest.raises(RecordingError, match=r'holds no .mcap file'):
        open_recording(tmp_path)


def test_other_files(tmp_path):
    (tmp_path / 'text.mcap').write_text('no recording at all')
    with pytest.raises(RecordingError, match='no mcap file, it starts otherwise'):
        open_recording(tmp_path / 'text.mcap')
    (tmp_path / 'bag.db3').write_text('SQLite format 3')
    with pytest.raises(RecordingError, match=r'is no .mcap file: .*`ros2 bag convert`'):
        open_recording(tmp_path / 'bag.db3')


def test_bags_stored_in_another_way(tmp_path):
    metadata = tmp_path / 'metadata.yaml'
    metadata.write_text('rosbag2_bagfile_information: {storage_identifier: sqlite3}')
    with pytest.raises(RecordingError, match='stored as sqlite3: convert it to mcap'):
        open_recording(tmp_path)
    metadata.write_text('rosbag2_bagfile_information: {compression_mode: FILE}')
    with pytest.raises(RecordingError, match='compressed by file: convert it'):
        open_recording(tmp_path)
    metadata.unlink()
    (tmp_path / 'bag_0.mcap.zstd').touch()
    with pytest.raises(RecordingError, match='unpack it with `zstd -d`'):
        open_recording(tmp_path)


@pytest.mark.parametrize('lost', [1, 30, 200, 2000])
def test_truncated_file_is_refused_and_saved_when_allowed(mcap, depth_images, lost):
    mcap.write_bytes(mcap.read_bytes()[:-lost])
    with pytest.raises(RecordingError, match=r'alone.mcap is truncated.*--allow-truncated'):
        open_recording(mcap)
    recording = open_recording(mcap, allow_truncated=True)
    assert recording.saved_count == sum(recording.topic_counts.values()) == 50
    np.testing.assert_array_equal(
        [frame.depth for frame in recording.depth_frames()], depth_images
    )


def test_truncated_file_without_a_whole_chunk_holds_nothing(mcap):
    mcap.write_bytes(mcap.read_bytes()[:5000])
    with pytest.raises(RecordingError, match='no message stands before the cut'):
        open_recording(mcap, allow_truncated=True)


def test_all_chunks_before_the_cut_are_saved(write_bag, random):
    # Noise of 200 kB a frame fills a chunk with every few frames.
    camera = PinholeCamera(240, 200, 200.0, 200.0, 120.0, 100.0)
    frames = random.random((12, 200, 240)).astype(np.float32)

    def write(bag):
        bag.write_depth_camera(camera, stamp_ns=STAMP, frame_id='d')

    path = write_bag(
        frames=frames, leave_out=('color', 'depth_camera'), extra=write, compression='none'
    )
    whole = open_recording(path, depth_camera=camera)
    assert whole.depth_count == 12
    file = next(path.glob('*.mcap'))
    file.write_bytes(file.read_bytes()[: int(0.6 * file.stat().st_size)])
    saved = open_recording(path, depth_camera=camera, allow_truncated=True)
    assert 4 <= saved.depth_count <= 7
    assert saved.saved_count == saved.depth_count + 2
    got = [frame.depth for frame in saved.depth_frames()]
    np.testing.assert_array_equal(got, frames[: saved.depth_count])


def test_every_flipped_byte_is_found(mcap, random):
    content = mcap.read_bytes()
    places = random.choice(len(content), 150, replace=False)
    # The last 100 bytes are the footer and its neighbours, the first ones the header.
    for place in [*places, *range(len(content) - 100, len(content)), *range(40)]:
        spoilt = bytearray(content)
        spoilt[place] ^= 0x10
        mcap.write_bytes(spoilt)
        with pytest.raises(RecordingError, match=r'is corrupt|is truncated|is no mcap file'):
            open_recording(mcap)


def test_flipped_byte_is_found_by_chunk_checksums_alone(mcap):
    content = bytearray(mcap.read_bytes())
    # Without the checksum over all data, as rosbag2 records by default.
    data_end = content.index(b'\x0f\x04' + bytes(7)) + 9
    content[data_end : data_end + 4] = bytes(4)
    middle = data_end // 2
    content[middle] ^= 0x10
    mcap.write_bytes(content)
    with pytest.raises(RecordingError, match=r'alone.mcap is corrupt.*cannot be unpacked'):
        list(open_recording(mcap).depth_frames())


def test_no_depth_topic_lists_what_there_is(write_bag):
    path = write_bag(leave_out=('depth', 'depth_camera'))
    with pytest.raises(
        RecordingError, match=r'no depth topic, only .*/color/image_raw \(sensor_msgs/msg/Image, b'
    ):
        open_recording(path)


def test_two_depth_topics_are_both_named(write_bag, depth_images):
    path = write_bag(extra=add_image('/aligned/image_raw', depth_images[0], '32FC1'))
    with pytest.raises(
        RecordingError,
        match=r'2 depth topics, /aligned/image_raw, /depth/image_rect_raw: .*--depth-topic',
    ):
        open_recording(path)
    assert open_recording(path, depth_topic='/depth/image_rect_raw').depth_count == 12


def test_infrared_is_no_depth_topic(write_bag, depth_images):
    grey = np.ones((36, 48), np.uint16)
    path = write_bag(extra=add_image('/infra1/image_rect_raw', grey, 'mono16'))
    assert open_recording(path).depth_topic == '/depth/image_rect_raw'


def test_wanted_topic_must_be_there_and_be_depth(write_bag):
    path = write_bag()
    with pytest.raises(RecordingError, match=r'/gone is no image topic .*/depth/image_rect_raw'):
        open_recording(path, depth_topic='/gone')
    with pytest.raises(RecordingError, match=r"/color/image_raw has the encoding 'bgr8'"):
        open_recording(path, depth_topic='/color/image_raw')
    with pytest.raises(RecordingError, match=r'/gone is no colour topic .*--color-topic'):
        open_recording(path, color_topic='/gone')


def test_unknown_encoding(write_bag):
    path = write_bag(
        leave_out=('depth',),
        extra=add_image('/depth/image_rect_raw', np.ones((36, 48)), '64FC1'),
    )
    with pytest.raises(RecordingError, match=r"has the encoding '64FC1': depth comes as 32FC1"):
        open_recording(path)


def test_no_camera_info(write_bag):
    path = write_bag(leave_out=('depth_camera',))
    with pytest.raises(
        RecordingError,
        match=r'no camera_info /depth/camera_info .*has /color/camera_info.*under .camera.',
    ):
        open_recording(path)
    with pytest.raises(RecordingError, match='there is none at all'):
        open_recording(write_bag(name='bare', leave_out=('depth_camera', 'color')))


def test_camera_info_of_another_size(write_bag, depth_camera):
    other = replace(depth_camera, width=96, height=72)
    path = write_bag(leave_out=('depth_camera',), extra=add_info(other))
    with pytest.raises(RecordingError, match=r'is for 96x72 pixels, but .* has 48x36'):
        open_recording(path)
    with pytest.raises(RecordingError, match=r"the scene's camera is for 96x72"):
        open_recording(path, depth_camera=other)


def test_zero_focal_length(write_bag, depth_camera):
    info = add_info(depth_camera, k=np.zeros(9), p=np.zeros(12))
    path = write_bag(leave_out=('depth_camera',), extra=info)
    with pytest.raises(RecordingError, match=r'/depth/camera_info: focal length is fx=0, fy=0'):
        open_recording(path)


def test_distorted_depth_camera(write_bag, depth_camera):
    bent = replace(depth_camera, distortion=(-0.1, 0.02, 0.0, 0.0, 0.0))
    path = write_bag(leave_out=('depth_camera',), extra=add_info(bent))
    with pytest.raises(
        RecordingError, match=r'distorted \(-0.1, 0.02, .*rectified depth topic .*--depth-topic'
    ):
        open_recording(path)


def test_rectified_images_are_seen_through_their_projection(write_bag, depth_camera):
    P = np.hstack([np.diag([38.0, 37.0, 1.0]), np.zeros((3, 1))])
    P[0, 2], P[1, 2] = 21.0, 17.5
    bent = replace(depth_camera, distortion=(-0.1, 0.02, 0.0, 0.0, 0.0))
    path = write_bag(leave_out=('depth_camera',), extra=add_info(bent, p=P.ravel()))
    camera = open_recording(path).depth_camera
    assert camera == PinholeCamera(48, 36, 38.0, 37.0, 21.0, 17.5)


def test_unknown_lens_model(write_bag, depth_camera):
    bent = replace(depth_camera, distortion=(-0.1, 0.02, 0.0, 0.0))
    path = write_bag(
        leave_out=('depth_camera',), extra=add_info(bent, distortion_model='equidistant')
    )
    with pytest.raises(RecordingError, match="lens model 'equidistant'"):
        open_recording(path)


@pytest.mark.parametrize('value', [0.0, np.nan])
def test_depth_all_invalid_in_every_frame(write_bag, value):
    path = write_bag(frames=np.full((3, 36, 48), value, np.float32))
    recording = open_recording(path)
    with pytest.raises(RecordingError, match=r'no depth in any of 3 frames, all zero or NaN'):
        list(recording.depth_frames())
    with pytest.raises(RecordingError, match=r'no depth in any of 3 frames'):
        list(recording.depth_frames(2))


def test_no_usable_frame_says_why(write_bag):
    def write(bag):
        image = image_message(
            np.ones((36, 48), np.float32), encoding='32FC1', stamp_ns=STAMP, frame_id='d'
        )
        image.data = image.data[:100]
        bag.write('/depth/image_rect_raw', image, STAMP)

    recording = open_recording(write_bag(leave_out=('depth',), extra=write))
    with pytest.raises(RecordingError, match=r'no usable frame \(1 times: .*is cut off'):
        list(recording.depth_frames())


def test_colour_without_a_camera_is_a_note(write_bag, color_images, color_camera):
    path = write_bag(
        leave_out=('color',), extra=add_image('/color/image_raw', color_images[0], 'bgr8')
    )
    recording = open_recording(path)
    assert recording.color_camera is None
    assert recording.notes == ('there is no camera_info /color/camera_info for /color/image_raw',)
    assert open_recording(path, color_camera=color_camera).color_camera == color_camera
    other = replace(color_camera, width=64)
    assert 'is for 64x24 pixels' in open_recording(path, color_camera=other).notes[0]


def test_limit_must_be_positive(write_bag):
    with pytest.raises(RecordingError, match='0 frames were asked for'):
        list(open_recording(write_bag()).depth_frames(0))
