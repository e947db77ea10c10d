# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The layouts for RViz and Foxglove show topics that the nodes have."""

import json
from pathlib import Path

from diffcal_ros.ros.calibration import CalibrationNode
from diffcal_ros.ros.depth_source import DepthSourceNode
from diffcal_ros.ros.estimate_messages import topic_of
from diffcal_ros.ros.marker_pose import MarkerPoseNode
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
import yaml

FOLDER = Path(__file__).resolve().parents[2] / 'rviz'
FOXGLOVE = json.loads((FOLDER / 'calibrate.foxglove.json').read_text())
RVIZ = yaml.safe_load((FOLDER / 'calibrate.rviz').read_text())
IMAGE, INFO = 'sensor_msgs/msg/Image', 'sensor_msgs/msg/CameraInfo'
MARKER, DIAGNOSTICS = 'visualization_msgs/msg/Marker', 'diagnostic_msgs/msg/DiagnosticArray'
# What the displays and panels can show.
DISPLAYED = {
    'rviz_default_plugins/DepthCloud': IMAGE,
    'rviz_default_plugins/Image': IMAGE,
    'rviz_default_plugins/Marker': MARKER,
}
SHOWN = {
    'imageTopic': IMAGE,
    'calibrationTopic': INFO,
    'topicToRender': DIAGNOSTICS,
    'topicPath': DIAGNOSTICS,
}
POLICIES = {
    'Reliable': ReliabilityPolicy.RELIABLE,
    'Best Effort': ReliabilityPolicy.BEST_EFFORT,
    'Transient Local': DurabilityPolicy.TRANSIENT_LOCAL,
    'Volatile': DurabilityPolicy.VOLATILE,
}
# Made when the first fit has found something.
_NUMBERS = f'/calibration/parameters/{topic_of("youngs_modulus")}/'


def _names(node):
    """Walk through whatever names a topic in a layout; yield it and the type that is shown."""
    if isinstance(node, dict):
        for key, value in node.items():
            is_topic = key.lower().endswith(('topic', 'topictorender', 'topicpath'))
            if is_topic and isinstance(value, str) and value:
                yield value, SHOWN[key]
            yield from _names(value)
    elif isinstance(node, list):
        for value in node:
            yield from _names(value)


def _leaves(node):
    if isinstance(node, str):
        return [node]
    return [*_leaves(node['first']), *_leaves(node['second'])]


def test_every_panel_of_foxglove_has_its_place():
    assert sorted(_leaves(FOXGLOVE['layout'])) == sorted(FOXGLOVE['configById'])


def test_topics_are_those_of_the_nodes(make_bench, write_scene):
    bench = make_bench({'scene': write_scene({'fit': ['youngs_modulus']}), 'pose_source': 'topic'})
    for node in (CalibrationNode, MarkerPoseNode, DepthSourceNode):
        bench.add(node)
    bench.until(lambda: 'calibration: fit' in bench.health, 'the nodes')
    there = dict(bench.probe.get_topic_names_and_types())
    panels = FOXGLOVE['configById']
    shown = [*_names(panels), *((name, MARKER) for name in panels['3D!view']['topics'])]
    in_rviz = [(f'/{topic["Value"]}', kind) for topic, kind in _topics_in_rviz()]
    assert len(shown) > 5
    assert len(in_rviz) > 5
    for name, kind in (*shown, *in_rviz):
        assert there.get(name) == [kind], name
    for camera in ('depth', 'color'):
        assert there[f'/{camera}/camera_info'] == [INFO]
    plotted = [path['value'] for path in panels['Plot!modulus']['paths']]
    assert plotted == [f'{_NUMBERS}value.data', f'{_NUMBERS}std_error.data']
    services = dict(bench.probe.get_service_names_and_types())
    assert services[panels['CallService!save']['serviceName']] == ['std_srvs/srv/Trigger']
    assert json.loads(panels['CallService!save']['requestPayload']) == {}
    for topic, _ in _topics_in_rviz():
        for publisher in bench.probe.get_publishers_info_by_topic(f'/{topic["Value"]}'):
            _check_offer(publisher.qos_profile, topic)


def _check_offer(offered, topic):
    """A display that asks for more than is offered shows nothing."""
    asked = [POLICIES[topic[f'{name} Policy']] for name in ('Reliability', 'Durability')]
    least = (ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE)
    for policy, have, enough in zip(
        asked, (offered.reliability, offered.durability), least, strict=True
    ):
        assert policy in (have, enough), topic


def _topics_in_rviz():
    """Yield the settings of each display's topic, and the type that is displayed."""
    for display in RVIZ['Visualization Manager']['Displays']:
        kind = DISPLAYED.get(display['Class'])
        if 'Depth Map Topic' in display:
            asked = {'Durability Policy': 'Volatile', **display}
            yield {**asked, 'Value': display['Depth Map Topic']}, kind
        elif 'Value' in display.get('Topic', {}):
            yield display['Topic'], kind
