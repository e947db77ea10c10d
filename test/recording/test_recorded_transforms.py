# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the colour camera is before the depth camera, as recordings tell."""

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.names import TF_TYPE, TRANSFORM_TYPE
from diffcal_ros.recording.topics.recorded_frames import read_frames
from diffcal_ros.recording.topics.ros_messages import message, transform_message
from diffcal_ros.rigid_transform import inverse
import numpy as np
import pytest

START_NS = 1_628_838_841_927_753_400


def test_transform_is_chained_through_other_frames(write_bag, depth_from_color, random):
    link_from_color = np.eye(4)
    link_from_color[:3, 3] = random.normal(size=3)

    def write(bag):
        edges = [
            transform_message(
                inverse(depth_from_color @ inverse(link_from_color)),
                parent='link',
                child='camera_depth_optical_frame',
                stamp_ns=START_NS,
            ),
            transform_message(
                link_from_color,
                parent='link',
                child='camera_color_optical_frame',
                stamp_ns=START_NS,
            ),
        ]
        for edge in edges:
            bag.write('/tf_static', message('tf2_msgs/msg/TFMessage', transforms=[edge]), START_NS)

    recording = open_recording(write_bag(leave_out=('transform',), extra=write))
    np.testing.assert_allclose(recording.depth_from_color, depth_from_color, atol=1e-12)


def test_latched_topic_alone_gives_the_transform(write_bag, depth_from_color):
    def write(bag):
        # Recorded the other way round; the frame names say so.
        turned = transform_message(
            inverse(depth_from_color),
            parent='camera_color_optical_frame',
            child='camera_depth_optical_frame',
            stamp_ns=START_NS,
        )
        bag.write('/camera/depth_from_color', turned, START_NS)

    recording = open_recording(write_bag(leave_out=('transform',), extra=write))
    np.testing.assert_allclose(recording.depth_from_color, depth_from_color, atol=1e-12)


def spoilt(parent, child):
    """A transform whose quaternion is zero."""
    stamped = transform_message(np.eye(4), parent=parent, child=child, stamp_ns=START_NS)
    stamped.transform.rotation.w = 0.0
    return message('tf2_msgs/msg/TFMessage', transforms=[stamped])


def test_unusable_transforms_elsewhere_do_not_matter(write_bag, depth_from_color):
    def write(bag):
        bag.write('/tf_static', spoilt('base_link', 'gripper'), START_NS)

    recording = open_recording(write_bag(extra=write))
    np.testing.assert_allclose(recording.depth_from_color, depth_from_color, atol=1e-12)


def test_transforms_on_topics_of_their_own_do_not_matter_either(write_bag, depth_from_color):
    def write(bag):
        zero = transform_message(np.eye(4), parent='world', child='rig', stamp_ns=START_NS)
        zero.transform.rotation.w = 0.0
        bag.write('/vicon/rig', zero, START_NS)
        lost = transform_message(np.eye(4), parent='', child='', stamp_ns=START_NS)
        lost.transform.translation.x = np.nan
        bag.write('/vicon/lost', lost, START_NS)

    recording = open_recording(write_bag(extra=write))
    np.testing.assert_allclose(recording.depth_from_color, depth_from_color, atol=1e-12)


@pytest.mark.parametrize('topic', ['/tf', '/tf_static', '/arm/tf_static', '/vicon'])
@pytest.mark.parametrize('content', [b'', b'\x00\x01\x00\x00', b'\xff' * 40])
def test_garbled_transforms_elsewhere_do_not_matter(
    write_bag, rewrite, depth_from_color, topic, content
):
    type_name = TRANSFORM_TYPE if topic == '/vicon' else TF_TYPE
    file = rewrite(write_bag(), foreign=(topic, type_name, content))
    recording = open_recording(file)
    np.testing.assert_allclose(recording.depth_from_color, depth_from_color, atol=1e-12)
    frames = read_frames(recording.messages, recording.leave_out)
    found = frames.find('camera_depth_optical_frame', 'camera_color_optical_frame')
    np.testing.assert_allclose(found, depth_from_color, atol=1e-12)


def test_an_unusable_transform_that_is_needed_is_refused(write_bag):
    def write(bag):
        edge = spoilt('camera_depth_optical_frame', 'camera_color_optical_frame')
        bag.write('/tf_static', edge, START_NS)

    bag = write_bag(leave_out=('transform',), extra=write)
    with pytest.raises(RecordingError, match='camera_depth_optical_frame is unusable, quaternion'):
        open_recording(bag)


def test_missing_transform_is_none(write_bag):
    assert open_recording(write_bag(leave_out=('transform',))).depth_from_color is None
