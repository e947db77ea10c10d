# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The calibration node takes the camera's pose from where the scene says."""

from importlib.util import find_spec

from diffcal_ros.ros.calibration import CalibrationNode
from diffcal_ros.ros.conversion import pose_message
from diffcal_ros.ros.qos import LATCHED
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image
from support.ros_images import camera_info, depth_image, world_pose

FIT = 'calibration: fit'
OK, WARN, ERROR = b'\x00', b'\x01', b'\x02'
WORLD_FROM_CAMERA = np.diag([1.0, -1.0, -1.0, 1.0])
WORLD_FROM_CAMERA[2, 3] = 0.4
POSE = {'source': 'topic', 'topic': '/hand_eye/pose', 'world_frame': 'rig_link'}


@pytest.fixture
def make_node(make_bench, write_scene):
    """Start a node on a scene with a `pose` section, and film for it."""

    def make(pose, **parameters):
        scene = write_scene({'fit': ['youngs_modulus'], 'pose': pose})
        # More frames than come, so that nothing is fitted.
        window = {'window.frames': 10, 'window.seconds': 3600.0}
        bench = make_bench({'scene': scene, **window, **parameters})
        node = bench.add(CalibrationNode)
        bench.publisher(CameraInfo, 'depth/camera_info').publish(camera_info())
        images = bench.publisher(Image, 'depth/image_rect_raw')
        for number in range(3):
            images.publish(depth_image(number))
        return bench, node

    return make


def in_world():
    message = PoseStamped()
    message.header.frame_id = 'rig_link'
    message.pose = pose_message(WORLD_FROM_CAMERA)
    return message


def test_a_pose_that_was_sent_once_on_the_scenes_topic_is_taken(make_node):
    bench, node = make_node(POSE)
    bench.status(FIT, WARN, 'waiting for /hand_eye/pose')
    latched = bench.probe.create_publisher(PoseStamped, '/hand_eye/pose', LATCHED)
    latched.publish(in_world())
    bench.until(lambda: node._session.inputs.pose is not None, 'the pose')
    bench.status(FIT, OK, 'collecting frames')
    pose = node._session.inputs.pose
    assert (pose.frame_id, pose.covariance) == ('rig_link', None)
    np.testing.assert_allclose(pose.frame_from_body, WORLD_FROM_CAMERA, atol=1e-12)
    assert bench.value(FIT, 'camera pose') == 'topic'


def test_with_covariance_it_is_taken_from_the_same_topic(make_node):
    bench, node = make_node(POSE)
    poses = bench.publisher(PoseWithCovarianceStamped, '/hand_eye/pose')
    message = world_pose(np.linalg.inv(WORLD_FROM_CAMERA))
    message.pose.covariance = (1e-6 * np.eye(6)).ravel()
    poses.publish(message)
    bench.until(lambda: node._session.inputs.pose is not None, 'the pose')
    np.testing.assert_allclose(node._session.inputs.pose.covariance, 1e-6 * np.eye(6))
    message.pose.covariance = np.ones(36)
    poses.publish(message)
    bench.status(FIT, ERROR, '/hand_eye/pose: the covariance is not positive definite')


def test_another_source_listens_elsewhere(make_node):
    bench, _ = make_node(POSE)
    bench.status(FIT, WARN, 'waiting for /hand_eye/pose')
    changed = bench.set_parameter('calibration', 'pose_source', 'stored')
    assert not changed.successful
    assert "has no 'stored_depth_from_world'" in changed.reason


@pytest.mark.skipif(find_spec('tf2_ros') is not None, reason='tf2 is installed')
def test_without_tf2_a_pose_from_tf_is_refused_with_the_cure(make_node):
    bench, _ = make_node({'source': 'tf', 'world_frame': 'rig_link'})
    bench.status(FIT, ERROR, 'tf: a pose from TF needs the package tf2_ros, which is not install')
    assert 'ros-jazzy-tf2-ros' in bench.health[FIT].message


@pytest.mark.skipif(find_spec('tf2_ros') is None, reason='tf2 is not installed')
def test_a_chain_of_tf_gives_the_pose(make_node):
    from geometry_msgs.msg import TransformStamped
    from tf2_ros import StaticTransformBroadcaster

    bench, node = make_node({'source': 'tf', 'world_frame': 'rig_link'})
    bench.status(FIT, WARN, "waiting for TF from 'rig_link'")
    sender = StaticTransformBroadcaster(bench.probe)
    stamped = TransformStamped(child_frame_id=depth_image().header.frame_id)
    stamped.header.frame_id = 'rig_link'
    stamped.transform.translation.z = 0.4
    stamped.transform.rotation.x, stamped.transform.rotation.w = 1.0, 0.0
    sender.sendTransform(stamped)
    bench.status(FIT, OK, 'collecting frames')
    frames = node._session.window.frames
    (seen,) = node._session.inputs.snapshot(frames).observe(node._session.scene)
    expected = np.linalg.inv(WORLD_FROM_CAMERA)
    np.testing.assert_allclose(seen.depth_from_world, expected, atol=1e-12)
