# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What images show of the depth camera that a scene names."""

from diffcal_ros.calibration.observations.observation import fuse_frames, measured_depth
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.observing.sensor_in_use import sensor_in_use
from diffcal_ros.scene.model import DepthSensor
from diffcal_ros.scene.sections.depth_sensors import SENSOR_MODELS
import numpy as np
import pytest

CAMERA = PinholeCamera(90, 70, 400.0, 410.0, 44.0, 36.0)
DISTANCE = 0.45


def surface():
    """A slanted plane [m], shape (70, 90)."""
    rows, columns = np.mgrid[:70, :90]
    return DISTANCE - 0.03 + 0.000413 * rows + 0.000297 * columns


def frames(step, *, cut=np.floor, noise=0.0, count=1, depth=None):
    random = np.random.default_rng(3)
    exact = surface() if depth is None else depth
    found = []
    for number in range(count):
        noisy = exact + noise * random.standard_normal(exact.shape)
        stepped = step * cut(noisy / step) if step else noisy
        found.append(DepthFrame(stepped.astype(np.float32), number))
    return found


def used(name, seen):
    sensor = SENSOR_MODELS[name].sensor(name)
    return sensor_in_use(sensor, seen, fuse_frames(seen), CAMERA, DISTANCE)


@pytest.mark.parametrize('name', ['realsense_l515', 'realsense_d405'])
def test_whole_millimetres_of_the_driver_lose_their_bias(name):
    seen = frames(0.001)
    sensor, (note,) = used(name, seen)
    assert 'whole steps of 1 mm' in note
    back = measured_depth(seen[0].depth, sensor)
    assert np.mean(seen[0].depth - surface()) == pytest.approx(-0.0005, abs=5e-5)
    assert np.mean(back - surface()) == pytest.approx(0.0, abs=5e-5)


@pytest.mark.parametrize(
    ('name', 'step'),
    [
        ('realsense_l515', 0.00025),
        ('realsense_d405', 0.0001),
        ('azure_kinect', 0.001),
        ('zed_2', 0),
    ],
)
def test_images_of_the_camera_itself_stay_as_they_are(name, step):
    seen = frames(step, cut=np.round)
    sensor, notes = used(name, seen)
    assert notes == []
    np.testing.assert_array_equal(measured_depth(seen[0].depth, sensor), seen[0].depth)
    assert sensor.noise >= SENSOR_MODELS[name].noise_at(DISTANCE, CAMERA.fx)


def test_depth_between_the_steps_is_told():
    sensor, (note,) = used('realsense_l515', frames(0.0001, cut=np.round))
    assert 'between the steps of 0.25 mm' in note
    assert sensor.quantization == 0.0


def test_depth_out_of_range_is_told_and_left_out():
    depth = surface()
    depth[:20] = 1.7
    seen = frames(0.0001, cut=np.round, depth=depth)
    sensor, (note,) = used('realsense_d405', seen)
    assert '29% of the depth lies outside 0.04 to 1 m' in note
    found = measured_depth(seen[0].depth, sensor)
    assert np.isnan(found[:20]).all()
    assert np.isfinite(found[20:]).all()


def test_far_more_noise_than_stated_is_told():
    quiet = used('realsense_d405', frames(0.0001, cut=np.round, noise=0.002, count=9))
    loud = used('realsense_d405', frames(0.0001, cut=np.round, noise=0.012, count=9))
    assert quiet[1] == []
    (note,) = loud[1]
    assert 'from frame to frame' in note


def test_a_scene_that_names_no_camera_is_believed():
    sensor = DepthSensor(noise=0.0001, quantization=0.00025)
    seen = frames(0.001, noise=0.01, count=6)
    assert sensor_in_use(sensor, seen, fuse_frames(seen), CAMERA, DISTANCE) == (sensor, [])
