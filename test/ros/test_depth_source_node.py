# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth source: recordings on topics, step by step and in loops; live topics with checks."""

import array
import itertools
import time

import cv2
from diffcal_ros.live.replay.replay_messages import Role
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.ros.conversion import depth_frame, stamp_ns, transform_matrix
from diffcal_ros.ros.depth_source import DepthSourceNode
from geometry_msgs.msg import TransformStamped
import numpy as np
import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_srvs.srv import Trigger
from support.ros_images import CAMERA, camera_info, depth_image, millimetre_image

REPLAY, LIVE = 'depth_source: replay', 'depth_source: live depth'
OK, WARN, ERROR = b'\x00', b'\x01', b'\x02'
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture
def bag(recorded_beam):
    (path,) = recorded_beam.bags.values()
    return path


def test_a_recording_comes_as_it_was_made(make_bench, bag):
    recording = open_recording(bag)
    bench = make_bench({'bag': bag, 'wait_for_subscriber': 1.0})
    images = bench.collect(Image, 'depth/image_rect_raw')
    infos = bench.collect(CameraInfo, 'depth/camera_info')
    colors = bench.collect(Image, 'color/image_raw')
    transforms = bench.collect(TransformStamped, 'depth_from_color', LATCHED)
    bench.add(DepthSourceNode)
    bench.status(REPLAY, OK, 'was replayed to its end')
    made = list(recording.depth_frames())
    bench.until(lambda: len(images) == len(made) and len(colors) == 2, 'all images')
    bench.until(lambda: infos and transforms, 'what tells of the camera')
    for image, frame in zip(images, made, strict=True):
        came = depth_frame(image)
        assert (came.stamp_ns, came.frame_id) == (frame.stamp_ns, frame.frame_id)
        np.testing.assert_array_equal(came.depth, frame.depth)
    assert infos[0].k[0] == recording.depth_camera.fx
    np.testing.assert_allclose(
        transform_matrix(transforms[0].transform), recording.depth_from_color, atol=1e-12
    )
    assert transforms[0].child_frame_id == recording.color_frame_id


@pytest.mark.slow
def test_it_waits_for_as_many_as_are_asked_for(make_bench, bag):
    bench = make_bench({'bag': bag, 'subscribers': 2, 'wait_for_subscriber': 60.0})
    images = bench.collect(Image, 'depth/image_rect_raw')
    node = bench.add(DepthSourceNode)
    sender = node._senders[Role.DEPTH]
    bench.until(lambda: sender.get_subscription_count() == 1, 'the first')
    waited = time.monotonic() + 4.0  # Longer than it waits for another to come.
    bench.until(lambda: time.monotonic() > waited, 'the time')
    assert not images
    bench.collect(Image, 'depth/image_rect_raw')
    bench.until(lambda: images, 'the first image')


def test_paused_it_goes_step_by_step(make_bench, bag):
    bench = make_bench({'bag': bag, 'paused': True, 'wait_for_subscriber': 1.0})
    images = bench.collect(Image, 'depth/image_rect_raw')
    bench.add(DepthSourceNode)
    bench.status(REPLAY, WARN, 'paused')
    for count in (1, 2):
        assert bench.call(Trigger, 'depth_source/step').success
        bench.until(lambda count=count: len(images) == count, 'one image')
    bench.until(lambda: bench.value(REPLAY, 'depth/image_rect_raw sent') == '2', 'the count')
    assert len(images) == 2
    assert bench.set_parameter('depth_source', 'paused', False).successful
    bench.status(REPLAY, OK, 'was replayed to its end')
    answer = bench.call(Trigger, 'depth_source/step')
    assert not answer.success
    assert 'has ended' in answer.message
    (images_before, _) = len(images), images.clear()
    assert bench.set_parameter('depth_source', 'loop', True).successful
    bench.until(lambda: len(images) > images_before, 'the recording again, and again')


def test_in_a_loop_stamps_go_on(make_bench, bag):
    bench = make_bench({'bag': bag, 'loop': True, 'wait_for_subscriber': 1.0})
    images = bench.collect(Image, 'depth/image_rect_raw')
    bench.add(DepthSourceNode)
    bench.until(lambda: len(images) >= 10, 'more images than were recorded')
    assert (np.diff([stamp_ns(image.header.stamp) for image in images]) > 0).all()
    answer = bench.call(Trigger, 'depth_source/step')
    assert not answer.success
    assert 'the replay runs' in answer.message


def test_bad_recordings_are_told_and_a_good_one_cures(make_bench, bag, tmp_path):
    (tmp_path / 'empty').mkdir()
    (tmp_path / 'blank.mcap').touch()
    (whole,) = bag.glob('*.mcap')
    content = bytearray(whole.read_bytes())
    content[len(content) // 3] ^= 0xFF
    (tmp_path / 'corrupt.mcap').write_bytes(content)
    (tmp_path / 'cut.mcap').write_bytes(whole.read_bytes()[: len(content) // 2])
    bench = make_bench({'bag': tmp_path / 'none', 'wait_for_subscriber': 1.0})
    images = bench.collect(Image, 'depth/image_rect_raw')
    bench.add(DepthSourceNode)
    bench.status(REPLAY, ERROR, 'there is no recording')
    for name, words in (
        ('none_either', 'there is no recording'),
        ('empty', 'holds no .mcap file'),
    ):
        answer = bench.set_parameter('depth_source', 'bag', str(tmp_path / name))
        assert not answer.successful
        assert words in answer.reason
    for name, words in (
        ('blank.mcap', 'blank.mcap'),
        ('corrupt.mcap', 'corrupt.mcap'),
        ('cut.mcap', 'is truncated'),
    ):
        assert bench.set_parameter('depth_source', 'bag', str(tmp_path / name)).successful
        bench.status(REPLAY, ERROR, words)
    assert 'the parameter allow_truncated' in bench.health[REPLAY].message
    assert not images
    assert bench.set_parameter('depth_source', 'bag', str(bag)).successful
    bench.status(REPLAY, OK, 'was replayed to its end')


@pytest.mark.slow
def test_live_topics_are_passed_on_and_bad_images_are_not(make_bench):
    bench = make_bench({'depth_from_color': '[0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]'})
    passed = bench.collect(Image, 'depth/image_rect_raw')
    transforms = bench.collect(TransformStamped, 'depth_from_color', LATCHED)
    bench.add(DepthSourceNode)
    answer = bench.call(Trigger, 'depth_source/step')
    assert not answer.success
    assert "set the parameter 'bag'" in answer.message
    depth = bench.publisher(Image, 'in/depth/image_rect_raw')
    info = bench.publisher(CameraInfo, 'in/depth/camera_info')
    color = bench.publisher(Image, 'in/color/image_raw')
    depth.publish(depth_image(encoding='yuv'))
    bench.status(LIVE, ERROR, "encoding is 'yuv'")
    info.publish(camera_info())
    unnamed, unstamped = depth_image(1), depth_image(2)
    unnamed.header.frame_id = ''
    unstamped.header.stamp.sec = unstamped.header.stamp.nanosec = 0
    good = millimetre_image(4, is_bigendian=True)
    # What was published last on a topic of its own may come first: wait for the camera_info.
    bench.until(lambda: bench.value(LIVE, 'messages received') == '1', 'the first image')
    for image in (unnamed, unstamped, depth_image(3, width=CAMERA.width // 2), good):
        depth.publish(image)
    bench.until(lambda: passed, 'the good image')
    assert passed == [good]
    bench.status(LIVE, WARN, '4 bad images')
    for reason in ('frame_id is empty', 'stamp is zero', 'image of 32x48, camera_info says 64x48'):
        assert bench.value(LIVE, f'bad: {reason}') == '1'
    picture = depth_image(5, encoding='mono8', step=CAMERA.width)
    picture.header.frame_id = 'camera_color_optical_frame'
    color.publish(picture)
    sent = bench.until(lambda: transforms, 'the transform')[0]
    assert sent.transform.translation.x == 0.01
    assert sent.child_frame_id == 'camera_color_optical_frame'
    bench.status(LIVE, WARN, 'no images on /in/depth/image_rect_raw for')


def test_compressed_depth_is_unpacked_while_there_is_no_other(make_bench):
    bench = make_bench()
    passed = bench.collect(Image, 'depth/image_rect_raw')
    bench.add(DepthSourceNode)
    packed = bench.publisher(CompressedImage, 'in/depth/image_rect_raw/compressedDepth')
    plain = millimetre_image(3, is_bigendian=False)
    pixels = np.frombuffer(plain.data, '<u2').reshape(CAMERA.height, CAMERA.width)
    body = cv2.imencode('.png', pixels)[1].tobytes()
    message = CompressedImage(header=plain.header, format='16UC1; compressedDepth png')
    message.data = array.array('B', bytes(12) + body[:40])
    packed.publish(message)
    bench.status(LIVE, ERROR, 'no 16-bit PNG')
    message.data = array.array('B', bytes(12) + body)
    packed.publish(message)
    bench.until(lambda: passed, 'the image')
    assert passed == [plain]


def test_one_bad_stamp_is_forgotten_and_lost_images_are_told(make_bench):
    bench = make_bench()
    node = bench.add(DepthSourceNode)
    depth = bench.publisher(Image, 'in/depth/image_rect_raw')
    unstamped = depth_image()
    unstamped.header.stamp.sec = unstamped.header.stamp.nanosec = 0
    depth.publish(unstamped)
    bench.status(LIVE, ERROR, 'stamp is zero')
    numbers = itertools.count()

    def film(words, level):
        status = bench.health[LIVE]
        depth.publish(depth_image(next(numbers)))
        return status.level == level and words in status.message

    bench.until(lambda: film('1 bad images', WARN), 'the good ones')
    # Ten seconds later, without waiting for them.
    node._relay._checked[Role.DEPTH]._bad._counts.clear()
    bench.until(lambda: film('images a second', OK), 'the end of it')
    (listener, *_) = node._relay._listeners
    listener._on_lost(148)
    bench.until(lambda: film('148 images', WARN), 'the loss')
    assert bench.value(LIVE, 'messages lost') == '148'
