# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The layouts for RViz and Foxglove show topics that the nodes have."""

import json
from pathlib import Path

from diffcal_ros.ros.calibration import CalibrationNode
from diffcal_ros.ros.depth_source import DepthSourceNode
from diffcal_ros.ros.estimate_messages import topic_of
from diffcal_ros.ros.marker_pose import MarkerPoseNode
import yaml

FOLDER = Path(__file__).resolve().parents[2] / 'rviz'
FOXGLOVE = json.loads((FOLDER / 'calibrate.foxglove.json').read_text())
RVIZ = yaml.safe_load((FOLDER / 'calibrate.rviz').read_text())
# Made when the first fit has found something.
_NUMBERS = f'/calibration/parameters/{topic_of("youngs_modulus")}/'


def _names(node):
    """Walk through whatever names a topic in a layout."""
    if isinstance(node, dict):
        for key, value in node.items():
            is_topic = key.lower().endswith(('topic', 'topictorender', 'topicpath'))
            if is_topic and isinstance(value, str) and value:
                yield value
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
    there = {name for name, _ in bench.probe.get_topic_names_and_types()}
    panels = FOXGLOVE['configById']
    shown = {*_names(panels), *panels['3D!view']['topics']}
    in_rviz = [one['Topic']['Value'] for one in _displays() if 'Value' in one.get('Topic', {})]
    in_rviz += [one['Depth Map Topic'] for one in _displays() if 'Depth Map Topic' in one]
    assert len(shown) > 5
    assert len(in_rviz) > 5
    assert {*shown, *(f'/{name}' for name in in_rviz)} <= there
    plotted = [path['value'] for path in panels['Plot!modulus']['paths']]
    assert plotted == [f'{_NUMBERS}value.data', f'{_NUMBERS}std_error.data']
    services = {name for name, _ in bench.probe.get_service_names_and_types()}
    assert panels['CallService!save']['serviceName'] in services


def _displays():
    return RVIZ['Visualization Manager']['Displays']
