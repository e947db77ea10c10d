# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters: wrong values are refused with a reason, and the shipped file lists them all."""

from pathlib import Path

from diffcal_ros.ros.calibration import CalibrationNode
from diffcal_ros.ros.calibration_parameters import SETTINGS as CALIBRATION
from diffcal_ros.ros.depth_source import DepthSourceNode
from diffcal_ros.ros.depth_source import SETTINGS as DEPTH_SOURCE
from diffcal_ros.ros.marker_pose import MarkerPoseNode
from diffcal_ros.ros.marker_pose import SETTINGS as MARKER_POSE
import pytest
from rcl_interfaces.srv import DescribeParameters
import yaml

SHIPPED = Path(__file__).resolve().parents[2] / 'config' / 'calibrate.yaml'
NODES = {
    'calibration': (CalibrationNode, CALIBRATION),
    'depth_source': (DepthSourceNode, DEPTH_SOURCE),
    'marker_pose': (MarkerPoseNode, MARKER_POSE),
}
WRONG = {
    'calibration': [
        ('loss', 'squared', 'use one of robust, paper, l1'),
        ('window.frames', 0, 'window.frames'),
        ('window.frames', 'many', "expected 'Type.INTEGER'"),
        ('device', 'cuda:9', 'cuda:9'),
        ('autostart', False, 'read-only'),
        ('pose_source', 'gps', 'use one of scene, estimated, stored, tf, topic'),
        ('world_frame', '/rig', "'/rig' is no name of a frame"),
        ('body_frame', 'scene_world', "two frames are called 'scene_world'"),
        ('out', '/dev/null/results', '/dev/null is no folder'),
    ],
    'depth_source': [
        ('rate', 0.0, 'rate'),
        ('depth_from_color', [1.0, 2.0], 'give x y z in metres and the quaternion'),
        ('depth_from_color', [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 'quaternion'),
        ('publish_clock', True, 'read-only'),
    ],
    'marker_pose': [
        ('marker.side', -0.02, 'marker.side'),
        ('window', 1000, 'window'),
        ('corner_refinement', 'magic', 'use one of edges, none, subpixel'),
        ('use_depth', False, 'read-only'),
        ('marker_frame', 'marker ', 'is no name of a frame'),
    ],
}


@pytest.mark.parametrize('name', NODES)
def test_wrong_values_are_refused_with_a_reason(make_bench, name):
    bench = make_bench()
    node = bench.add(NODES[name][0])
    for parameter, value, reason in WRONG[name]:
        before = node.get_parameter(parameter).value
        answer = bench.set_parameter(name, parameter, value)
        assert not answer.successful, parameter
        assert reason in answer.reason
        assert node.get_parameter(parameter).value == before
    described = bench.call(
        DescribeParameters,
        f'{name}/describe_parameters',
        DescribeParameters.Request(names=[setting.name for setting in NODES[name][1]]),
    )
    assert all(descriptor.description for descriptor in described.descriptors)


@pytest.mark.parametrize('name', NODES)
def test_the_shipped_file_lists_every_parameter_at_its_default(make_bench, name):
    document = yaml.safe_load(SHIPPED.read_text())
    listed = document[f'/**/{name}']['ros__parameters']
    assert listed == {setting.name: setting.default for setting in NODES[name][1]}


def test_the_shipped_file_reaches_the_nodes(make_bench, tmp_path):
    changed = SHIPPED.read_text().replace('rate: 1.0', 'rate: 2.5')
    (tmp_path / 'own.yaml').write_text(changed)
    bench = make_bench(arguments=['--params-file', str(tmp_path / 'own.yaml')])
    assert bench.add(DepthSourceNode).get_parameter('rate').value == 2.5


def test_a_fit_that_the_scene_cannot_have_is_refused(make_bench, write_scene):
    bench = make_bench({'scene': write_scene({'fit': ['youngs_modulus']}), 'pose_source': 'topic'})
    bench.add(CalibrationNode)
    bench.until(lambda: bench.value('calibration: fit', 'state'), 'a session')
    answer = bench.set_parameter('calibration', 'fit', 'colour')
    assert not answer.successful
    assert 'colour' in answer.reason
    answer = bench.set_parameter('calibration', 'observation', 'upside_down')
    assert not answer.successful
    assert 'upside_down' in answer.reason
    for scene, reason in (('', 'there is no scene'), ('/nowhere/scene.yaml', 'scene.yaml')):
        answer = bench.set_parameter('calibration', 'scene', scene)
        assert not answer.successful
        assert reason in answer.reason


def test_markers_that_would_not_be_looked_for_are_refused(make_bench, write_scene, capfd):
    scene = write_scene({})
    bench = make_bench({'scene': scene, 'marker.id': 7})
    bench.add(MarkerPoseNode)
    assert 'marker.id not used: the scene' in capfd.readouterr().err
    answer = bench.set_parameter('marker_pose', 'marker.side', 0.03)
    assert not answer.successful
    assert "set the parameter scene to ''" in answer.reason
    answer = bench.set_parameter('marker_pose', 'scene', str(scene.parent / 'none.yaml'))
    assert not answer.successful
    assert bench.set_parameter('marker_pose', 'scene', '').successful
    answer = bench.set_parameter('marker_pose', 'marker.dictionary', 'DICT_9X9_7')
    assert not answer.successful
    assert 'DICT_9X9_7' in answer.reason
    assert bench.set_parameter('marker_pose', 'marker.side', 0.03).successful


def test_a_scene_that_does_not_exist_is_an_error_and_a_good_one_cures_it(make_bench, write_scene):
    scene = write_scene({'fit': ['youngs_modulus']})
    bench = make_bench({'scene': scene.parent / 'none.yaml', 'pose_source': 'topic'})
    bench.add(CalibrationNode)
    bench.status('calibration: fit', b'\x02', 'none.yaml')
    assert bench.set_parameter('calibration', 'scene', str(scene)).successful
    bench.status('calibration: fit', b'\x01', 'waiting for depth/image_rect_raw')
