# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The launch file: what each argument starts, and with which topics."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

pytest.importorskip('launch_ros', reason='ros2 launch is not installed')

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / 'launch' / 'calibrate.launch.py'
SCENE, BAG = str(ROOT / 'bags/sample/scene.yaml'), str(ROOT / 'bags/sample/bag')


@pytest.fixture
def launched(monkeypatch, tmp_path):
    """`launched(**arguments)` gives the module, its actions, and the context with arguments."""
    from launch import LaunchContext

    marker = tmp_path / 'share' / 'ament_index' / 'resource_index' / 'packages' / 'diffcal_ros'
    marker.parent.mkdir(parents=True)
    marker.touch()
    (tmp_path / 'share' / 'diffcal_ros').symlink_to(ROOT)
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    spec = spec_from_file_location('calibrate_launch', FILE)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)

    def start(**given):
        context = LaunchContext()
        arguments = {name: default or '' for name, default, _ in module.ARGUMENTS}
        context.launch_configurations.update({**arguments, 'scene': SCENE, **given})
        return module, context

    return start


def _remapped(node):
    return {source[0].text: target[0].text for source, target in node._Node__remappings}


def _parameters(node, context):
    from launch_ros.utilities import evaluate_parameters

    given = [p for p in node._Node__parameters if isinstance(p, dict)]
    (found,) = evaluate_parameters(context, given)
    return found


@pytest.mark.parametrize(
    ('camera', 'depth', 'color_info'),
    [
        (
            'realsense',
            '/camera/camera/depth/image_rect_raw',
            '/camera/camera/color/camera_info',
        ),
        ('orbbec', '/camera/depth/image_raw', '/camera/color/camera_info'),
        ('azure_kinect', '/depth/image_rect', '/rgb/camera_info'),
        (
            'zed',
            '/zed/zed_node/depth/depth_registered',
            '/zed/zed_node/rgb/color/rect/camera_info',
        ),
        ('/arm/camera', '/arm/camera/depth/image_rect_raw', '/arm/camera/color/camera_info'),
    ],
)
def test_a_camera_maps_the_topics_of_its_driver(launched, camera, depth, color_info):
    module, context = launched(camera=camera)
    *_, source = module._nodes(context)
    remapped = _remapped(source)
    assert list(remapped) == [f'in/{topic}' for topic in module.INPUTS]
    assert remapped['in/depth/image_rect_raw'] == depth
    assert remapped['in/color/camera_info'] == color_info
    assert 'bag' not in _parameters(source, context)


def test_a_topic_goes_before_what_the_camera_says(launched):
    module, context = launched(camera='orbbec', depth_topic='/top/depth')
    topics = module.camera_topics(context)
    assert topics[:2] == ('/top/depth', '/camera/depth/camera_info')
    _, context = launched(camera='kinect')
    with pytest.raises(ValueError, match="camera is 'kinect': use realsense, orbbec"):
        module.camera_topics(context)


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        ({'camera': 'kinect'}, "camera is 'kinect'"),
        ({'rate': 'fast'}, "rate is 'fast': use a number"),
        ({'loop': 'maybe'}, "loop is 'maybe': use true or false"),
        ({'rviz': 'no'}, "rviz is 'no': use true or false"),
        ({'use_sim_time': ''}, 'use_sim_time must not be empty'),
        ({'params_file': '/nowhere.yaml'}, "there is no file '/nowhere.yaml'"),
    ],
)
def test_what_cannot_be_used_is_refused_before_anything_starts(launched, given, words):
    from launch.actions import GroupAction, OpaqueFunction

    module, context = launched(**given)
    with pytest.raises(ValueError, match=words):
        module.check_arguments(context)
    started = module.generate_launch_description().entities
    checks = [place for place, one in enumerate(started) if isinstance(one, OpaqueFunction)]
    groups = [place for place, one in enumerate(started) if isinstance(one, GroupAction)]
    assert checks[0] < groups[0]


def test_every_value_in_the_help_is_taken(launched):
    for camera in ('orbbec', '/arm'):
        module, context = launched(camera=camera, rate='0.5', loop='True', rviz='false')
        module.check_arguments(context)


def test_what_is_not_given_stays_as_the_parameter_file_says(launched):
    module, context = launched(bag=BAG, rate='2', loop='true', use_sim_time='true')
    calibration, _, source = module._nodes(context)
    found = _parameters(source, context)
    assert (found['bag'], found['rate'], found['loop']) == (BAG, 2.0, True)
    assert found['publish_clock'] is True
    assert found['use_sim_time'] is True
    assert 'out' not in _parameters(calibration, context)
    _, context = launched(bag=BAG, use_sim_time='false')
    *_, source = module._nodes(context)
    assert not {'rate', 'loop'} & set(_parameters(source, context))


def test_without_rviz2_the_rest_is_started(launched):
    module, context = launched(rviz='true')
    assert module._rviz(context) == []
