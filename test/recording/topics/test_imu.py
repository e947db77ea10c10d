# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an accelerometer at rest felt, and where that points in another frame."""

from diffcal_ros.recording.bag.bag_files import bag_files
from diffcal_ros.recording.bag.mcap_messages import McapMessages
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.frame_tree import FrameTree
from diffcal_ros.recording.topics.imu import IMU_TYPE, read_imus, RestingImu
from diffcal_ros.recording.topics.ros_messages import header, message
from diffcal_ros.rigid_transform import rotation_matrix, transform
import numpy as np
import pytest


def imu_message(acceleration, stamp_ns: int):
    def vector(values):
        x, y, z = (float(value) for value in values)
        return message('geometry_msgs/msg/Vector3', x=x, y=y, z=z)

    nothing = np.zeros(9)
    return message(
        IMU_TYPE,
        header=header(stamp_ns, 'imu_link'),
        orientation=message('geometry_msgs/msg/Quaternion', x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=nothing,
        angular_velocity=vector((0, 0, 0)),
        angular_velocity_covariance=nothing,
        linear_acceleration=vector(acceleration),
        linear_acceleration_covariance=nothing,
    )


def written(folder, accelerations) -> McapMessages:
    with BagWriter(folder) as bag:
        for number, own in enumerate(accelerations):
            bag.write('/camera/imu', imu_message(own, 1_000_000 * (number + 1)), number + 1)
    return McapMessages(bag_files(folder))


def test_the_mean_of_what_was_felt_is_read(tmp_path):
    felt = [(0.1, -9.8, 0.3), (-0.1, -9.8, 0.1)]
    (imu,) = read_imus(written(tmp_path / 'bag', felt), lambda raw, error: None)
    assert imu.topic == '/camera/imu'
    assert imu.frame_id == 'imu_link'
    assert imu.acceleration == pytest.approx([0.0, -9.8, 0.2])
    assert imu.is_plausible


def test_a_gyroscope_alone_is_no_accelerometer(tmp_path):
    assert read_imus(written(tmp_path / 'bag', [(0, 0, 0)] * 3), lambda raw, error: None) == []


def test_a_camera_that_is_shaken_feels_more_than_gravity():
    assert not RestingImu('/imu', 'imu_link', np.array([0.0, 0.0, 13.0])).is_plausible


def test_gravity_points_against_what_was_felt_in_the_cameras_frame():
    imu = RestingImu('/imu', 'imu_link', np.array([0.0, 0.0, 9.8]))
    tree = FrameTree()
    turn = rotation_matrix(np.deg2rad([20.0, 0.0, 0.0]))
    tree.add('depth', 'imu_link', transform(turn, np.array([0.1, 0.2, 0.3])))
    expected = [0.0, np.sin(np.deg2rad(20.0)), -np.cos(np.deg2rad(20.0))]
    assert imu.down_in('depth', tree) == pytest.approx(expected)
    assert imu.down_in('imu_link', tree) == pytest.approx([0.0, 0.0, -1.0])
    assert imu.down_in('elsewhere', tree) is None
