# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The three nodes as processes: the sample bag ends in the command line's number."""

import json
import os
from pathlib import Path
import subprocess
import sys

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from diffcal_ros import calibrate, load_scene, open_inputs
import numpy as np
import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Trigger

SAMPLE = Path(__file__).resolve().parents[2] / 'bags' / 'sample'
LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Live and offline fuse the same frames; the marker's pose may rest on other depth images.
SAME = 1e-3
NODES = ('calibration', 'marker_pose', 'depth_source')


def _outcome(messages: list[DiagnosticArray]) -> str:
    values = {p.key: p.value for m in messages[-1:] for p in m.status[0].values}
    return '' if values.get('outcome', 'running') == 'running' else values['outcome']


@pytest.mark.slow
def test_the_sample_bag_ends_in_the_same_modulus_as_offline(make_bench, start_node, tmp_path):
    scene = SAMPLE / 'scene.yaml'
    out = tmp_path / 'out'
    calibration = start_node(
        'calibration', {'scene': scene, 'out': out, 'mesh_error': False, 'refit': 'once'}
    )
    marker = start_node('marker_pose', {'scene': scene})
    source = start_node(
        'depth_source', {'bag': SAMPLE / 'bag', 'subscribers': 2, 'wait_for_subscriber': 60.0}
    )
    inputs = open_inputs(load_scene(scene), [])
    offline = calibrate(inputs.scene, inputs.observations)['youngs_modulus']
    bench = make_bench()
    estimates = bench.collect(DiagnosticArray, 'calibration/estimates', LATCHED)
    covariance = bench.collect(Float64MultiArray, 'calibration/covariance', LATCHED)
    # It may have ended before we came: what counts is latched.
    # Kernels may have to be compiled first.
    assert bench.until(lambda: _outcome(estimates), 'the end of the fit', 300.0) == 'converged'
    found = {s.name: {p.key: p.value for p in s.values} for s in estimates[-1].status}
    live = found['youngs_modulus']
    assert float(live['value']) == pytest.approx(offline.value, rel=SAME)
    assert (live['unit'], live['fixed']) == ('Pa', 'false')
    assert found['poissons_ratio']['fixed'] == 'true'
    bench.until(lambda: covariance, 'the covariance')
    names = covariance[-1].layout.dim[0].label.split(',')
    errors = np.sqrt(np.diag(np.reshape(covariance[-1].data, (len(names), len(names)))))
    modulus_error = errors[names.index('youngs_modulus')]
    assert float(live['std_error']) == pytest.approx(modulus_error, rel=1e-6)

    answer = bench.call(Trigger, 'calibration/save')
    assert answer.success, answer.message
    saved = json.loads((out / 'result.json').read_text())
    saved_modulus = saved['parameters']['youngs_modulus']['value']
    assert saved_modulus == pytest.approx(float(live['value']), rel=1e-6)
    fitted = load_scene(out / 'fitted_scene.yaml').regions[0].youngs_modulus.start
    assert fitted == pytest.approx(saved_modulus, rel=1e-6)

    verdicts = bench.collect(DiagnosticArray, 'calibration/verdict', LATCHED)
    answer = bench.call(Trigger, 'calibration/diagnose')
    assert answer.success, answer.message
    bench.until(lambda: verdicts, 'the verdict', 300.0)
    told = {p.key: p.value for p in verdicts[-1].status[0].values}
    written = json.loads((out / 'diagnosis' / 'verdict.json').read_text())
    # The sample's mesh is coarse on purpose; a false alarm it must not be.
    assert told['verdict'] == written['verdict']
    assert told['verdict'] in ('agree', 'cannot_tell')
    assert (out / 'diagnosis' / 'diagnosis.html').is_file()
    # There is nothing to add, and nothing to take out.
    for service, reason in (('accept_effect', 'found no effect'), ('revert_effect', 'no effect')):
        answer = bench.call(Trigger, f'calibration/{service}')
        assert not answer.success
        assert reason in answer.message

    for node in (calibration, marker, source):
        assert node.interrupt() == 0, node.output
        assert 'Traceback' not in node.output


@pytest.mark.slow
def test_a_second_node_of_the_same_name_says_so_and_ends(start_node, make_bench):
    first = start_node('depth_source')
    second = start_node('depth_source')
    bench = make_bench()
    both = (first, second)
    ended = bench.until(
        lambda: next((node for node in both if node.child.poll() is not None), None),
        'the end of one of them',
    )
    assert ended.child.returncode == 2
    assert 'another node is called /depth_source' in ended.output
    assert 'Traceback' not in ended.output


@pytest.mark.slow
def test_bare_nodes_say_what_they_want_and_end_without_a_trace(start_node, make_bench):
    nodes = [start_node(name) for name in NODES]
    bench = make_bench()
    bench.status('calibration: fit', DiagnosticStatus.ERROR, 'there is no scene')
    bench.status('marker_pose: pose', DiagnosticStatus.WARN, 'waiting for color/camera_info')
    bench.status('depth_source: live depth', DiagnosticStatus.WARN, 'waiting for images')
    for node in nodes:
        assert node.interrupt() == 0, node.output
        assert 'Traceback' not in node.output


@pytest.mark.parametrize(
    ('variables', 'arguments', 'words'),
    [
        ({}, ['--params-file', '/nowhere.yaml'], "Couldn't parse params file"),
        ({}, ['--no-such-option'], 'check what follows --ros-args'),
        ({'ROS_DOMAIN_ID': 'mine'}, [], 'ROS_DOMAIN_ID (0 to 101)'),
        ({'ROS_LOG_DIR': '/dev/null/log'}, [], 'ROS_LOG_DIR'),
    ],
)
@pytest.mark.slow_but_first
def test_what_ros_gives_up_at_is_told(variables, arguments, words):
    code = 'import sys; from diffcal_ros.ros.marker_pose_node import main; sys.exit(main())'
    done = subprocess.run(
        [sys.executable, '-c', code, '--ros-args', *arguments],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert 'ROS cannot be started (' in done.stderr
    assert words in done.stderr
    assert 'Traceback' not in done.stderr


@pytest.mark.slow
def test_a_wrong_value_at_the_start_ends_the_node_with_a_sentence(start_node):
    node = start_node('calibration', {'loss': 'squared'})
    assert node.child.wait(60.0) == 2
    assert "loss is 'squared': use one of robust, paper, l1" in node.output
    assert 'Traceback' not in node.output
