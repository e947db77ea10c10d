# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from pathlib import Path
import subprocess
import sys

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.ros_messages import header, message
from mcap.reader import NonSeekingReader
from mcap.stream_reader import StreamReader
import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability
import yaml

TOPICS = {
    '/tf_static': 1,
    '/depth_from_color': 1,
    '/depth/camera_info': 12,
    '/depth/image_rect_raw': 12,
    '/color/camera_info': 12,
    '/color/image_raw': 12,
}


@pytest.mark.parametrize('compression', ['zstd', 'lz4', 'none'])
def test_other_readers_accept_the_bag(write_bag, compression, depth_images):
    path = write_bag(compression=compression)
    with AnyReader([path]) as reader:
        assert {name: topic.msgcount for name, topic in reader.topics.items()} == TOPICS
        depth = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic == '/depth/image_rect_raw'
        ]
    np.testing.assert_array_equal(
        np.array([image.data.view(np.float32).reshape(36, 48) for image in depth]), depth_images
    )
    with next(path.glob('*.mcap')).open('rb') as stream:
        read = NonSeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False)
        assert sum(1 for _ in read) == sum(TOPICS.values())


def test_metadata_is_that_of_jazzy(write_bag):
    path = write_bag()
    document = yaml.safe_load((path / 'metadata.yaml').read_text())
    information = document['rosbag2_bagfile_information']
    assert information['version'] == 9
    assert information['relative_file_paths'] == ['bag_0.mcap']
    assert information['message_count'] == sum(TOPICS.values())
    assert information['files'][0]['message_count'] == sum(TOPICS.values())
    assert information['duration']['nanoseconds'] == 11 * 33_333_333
    # rosbag2 knows no YAML references.
    assert '&' not in (path / 'metadata.yaml').read_text()


def test_transforms_are_latched_and_images_are_not(write_bag):
    with AnyReader([write_bag()]) as reader:
        offered = {c.topic: c.ext.offered_qos_profiles[0].durability for c in reader.connections}
    assert offered['/tf_static'] is QosDurability.TRANSIENT_LOCAL
    assert offered['/depth_from_color'] is QosDurability.TRANSIENT_LOCAL
    assert offered['/depth/image_rect_raw'] is QosDurability.VOLATILE


def test_every_checksum_is_written(write_bag):
    with next(write_bag().glob('*.mcap')).open('rb') as stream:
        records = list(StreamReader(stream, emit_chunks=True).records)
    found = {type(record).__name__: record for record in records}
    assert found['DataEnd'].data_section_crc
    assert found['Footer'].summary_crc
    assert found['Chunk'].uncompressed_crc
    assert found['Header'].profile == 'ros2'
    assert found['Schema'].encoding == 'ros2msg'


def test_any_message_can_be_written(tmp_path):
    pose = message(
        'geometry_msgs/msg/PoseStamped',
        header=header(1_500_000_000, 'world'),
        pose=message(
            'geometry_msgs/msg/Pose',
            position=message('geometry_msgs/msg/Point', x=1.0, y=2.0, z=3.0),
            orientation=message('geometry_msgs/msg/Quaternion', x=0.0, y=0.0, z=0.0, w=1.0),
        ),
    )
    with BagWriter(tmp_path / 'poses') as bag:
        bag.write('/pose', pose, 1_500_000_000)
    with AnyReader([tmp_path / 'poses']) as reader:
        ((connection, stamp, data),) = reader.messages()
        read = reader.deserialize(data, connection.msgtype)
    assert (connection.topic, stamp) == ('/pose', 1_500_000_000)
    assert (read.header.stamp.sec, read.header.stamp.nanosec) == (1, 500_000_000)
    assert read.pose.position.z == 3.0


def test_millimetres_are_rounded_and_what_does_not_fit_is_invalid(write_bag, depth_camera):
    depth = np.full((1, 36, 48), 0.4004, np.float32)
    depth[0, 0, :4] = [np.nan, 70.0, 0.4006, np.inf]
    path = write_bag(encoding='16UC1', frames=depth)
    (frame,) = open_recording(path).depth_frames()
    np.testing.assert_allclose(frame.depth[0, :5], [np.nan, np.nan, 0.401, np.nan, 0.4])


def test_nothing_is_left_after_an_error(tmp_path, depth_images):
    def write():
        with BagWriter(tmp_path / 'bag') as bag:
            bag.write_depth(DepthFrame(depth_images[0], 0, 'd'))
            raise KeyError('stop')

    with pytest.raises(KeyError, match='stop'):
        write()
    assert list(tmp_path.iterdir()) == []


def test_existing_bag_is_kept_unless_overwriting(write_bag, tmp_path, depth_images):
    path = write_bag()
    with pytest.raises(RecordingError, match=r'bag exists already: remove it'):
        BagWriter(path)
    with BagWriter(path, overwrite=True) as bag:
        bag.write_depth(DepthFrame(depth_images[0], 0, 'd'))
    with AnyReader([path]) as reader:
        assert reader.message_count == 1
    assert [entry.name for entry in tmp_path.iterdir()] == ['bag']


def test_other_folders_are_never_overwritten(tmp_path):
    (tmp_path / 'precious').mkdir()
    with pytest.raises(RecordingError, match='precious is no bag and is not overwritten'):
        BagWriter(tmp_path / 'precious', overwrite=True)


def test_unknown_compression_and_encoding_are_refused(tmp_path, depth_images):
    with pytest.raises(RecordingError, match=r"'gzip': zstd, lz4, none are written"):
        BagWriter(tmp_path / 'bag', compression='gzip')
    with (
        pytest.raises(RecordingError, match=r"'mono16': 32FC1 or 16UC1"),
        BagWriter(tmp_path / 'bag') as bag,
    ):
        bag.write_depth(DepthFrame(depth_images[0], 0, 'd'), encoding='mono16')


def test_one_topic_carries_one_type(tmp_path, depth_camera):
    number = message('std_msgs/msg/Float64', data=1.0)
    with BagWriter(tmp_path / 'bag') as bag:
        bag.write_depth_camera(depth_camera, stamp_ns=0, frame_id='d')
        with pytest.raises(ValueError, match='carries sensor_msgs/msg/CameraInfo, not std_msgs'):
            bag.write('/depth/camera_info', number, 0)


def test_stamps_before_the_epoch_are_refused(tmp_path, depth_images):
    with pytest.raises(ValueError, match='stamp is -5 ns'), BagWriter(tmp_path / 'bag') as bag:
        bag.write_depth(DepthFrame(depth_images[0], -5, 'd'))


# A limit on the size of files stands for a full disk: the same place fails in the same way.
_FULL_DISK = """
import resource, sys
import numpy as np
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_writer import BagWriter
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
noise = np.random.default_rng(1).random((200, 300)).astype(np.float32)
try:
    with BagWriter(sys.argv[1]) as bag:
        for stamp in range(int(sys.argv[3])):
            bag.write_depth(DepthFrame(noise, stamp, 'd'))
except RecordingError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform == 'win32', reason='needs POSIX resource limits')
@pytest.mark.parametrize(('limit', 'frames'), [(300_000, 20), (100_000, 1)])
def test_full_disk_is_said_and_leaves_nothing(tmp_path, limit, frames):
    root = Path(__file__).resolve().parents[2]
    command = [sys.executable, '-c', _FULL_DISK, str(tmp_path / 'bag'), str(limit), str(frames)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=root)
    assert 'bag cannot be written: the disk is full' in done.stdout
    assert list(tmp_path.iterdir()) == []


def test_unwritable_place_is_said(tmp_path):
    (tmp_path / 'file').write_text('in the way')
    writer = BagWriter(tmp_path / 'file' / 'bag')
    with pytest.raises(RecordingError, match='cannot be written'):
        writer.__enter__()
