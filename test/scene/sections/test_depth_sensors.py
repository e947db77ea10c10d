# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A depth camera by its name in a scene."""

import math

from diffcal_ros.errors import InputError
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import DepthSensor
from diffcal_ros.scene.sections.depth_sensors import SENSOR_MODELS
import pytest


@pytest.fixture
def read(write_scene):
    """Read a scene's section about the depth camera."""
    return lambda **sensor: load_scene(write_scene({'sensor': sensor})).sensor


def test_a_name_brings_the_figures_of_the_data_sheet(read):
    sensor = read(model='realsense_d405')
    assert (sensor.quantization, sensor.nearest, sensor.farthest) == (0.0001, 0.04, 1.0)
    assert sensor.driver_step == 0.001


def test_what_the_scene_states_goes_before_the_data_sheet(read):
    sensor = read(model='realsense_l515', noise=0.0003, farthest=2.0, quantization=0.001)
    assert (sensor.noise, sensor.farthest, sensor.quantization) == (0.0003, 2.0, 0.001)
    assert sensor.nearest == 0.25
    # Neither noise nor steps are asked of the data sheet or the images any more.
    assert (sensor.model, sensor.driver_step) == ('', 0.0)


def test_a_scene_without_a_name_has_no_range(read):
    sensor = read(noise=0.0002)
    assert sensor == DepthSensor(noise=0.0002)
    assert (sensor.nearest, sensor.farthest) == (0.0, math.inf)


def test_a_smooth_error_is_stated_beside_a_name(read):
    assert read(model='realsense_d405', smooth_error=0.001).smooth_error == 0.001
    assert read(model='realsense_d405').smooth_error == 0.0


@pytest.mark.parametrize(
    ('sensor', 'words'),
    [
        ({'smooth_error': 0.0}, 'sensor.smooth_error'),
        ({'smooth_error': 1.5}, 'between 0 and 1'),
        ({'model': 'realsense_d453'}, 'realsense_d435'),
        ({'model': 'realsense_d405', 'nearest': 1.5}, 'less than farthest, 1 m'),
        ({'farthest': 600.0}, 'sensor.farthest'),
    ],
)
def test_a_mistake_says_what_is_allowed(read, sensor, words):
    with pytest.raises(InputError, match=words):
        read(**sensor)


def test_noise_of_a_stereo_camera_is_that_of_its_disparity():
    # A disparity of f b / z: where it is off by 0.08 px, depth is off by its derivative.
    known, focal = SENSOR_MODELS['realsense_d435'], 640.0
    for distance in (0.3, 0.8, 2.0):
        disparity = focal * 0.05 / distance
        off = focal * 0.05 / (disparity - 0.04) - focal * 0.05 / (disparity + 0.04)
        assert known.noise_at(distance, focal) == pytest.approx(off, rel=1e-2)


def test_noise_of_time_of_flight_ends_at_what_the_data_sheets_state():
    lidar, kinect = SENSOR_MODELS['realsense_l515'], SENSOR_MODELS['azure_kinect']
    assert lidar.noise_at(1.0, 500.0) == pytest.approx(0.0025, rel=0.01)
    assert lidar.noise_at(9.0, 500.0) == pytest.approx(0.0155, rel=0.02)
    assert kinect.noise_at(5.46, 500.0) == pytest.approx(0.017)
    assert kinect.noise_at(0.6, 500.0) == pytest.approx(0.017 * (0.6 / 5.46) ** 2)


@pytest.mark.parametrize('name', SENSOR_MODELS)
def test_every_camera_is_whole(name):
    known = SENSOR_MODELS[name]
    assert 0.0 < known.nearest < known.farthest
    assert known.title
    assert known.source
    assert 1e-6 < known.noise_at(0.5, 600.0) < 0.01
    assert known.sensor(name).model == name
