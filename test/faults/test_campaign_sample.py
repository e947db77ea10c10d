# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sample of the campaign in benchmarks/faults: messages, scenes, machines, signals and kills.

The damaged bags of the sample are in test/recording. Other seeds than the campaign's own.
"""

from pathlib import Path
import sys

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))
from benchmarks.faults.cases import sample  # noqa: E402
from benchmarks.faults.content import CHANGES, content_cases  # noqa: E402
from benchmarks.faults.environments import environment_cases  # noqa: E402
from benchmarks.faults.kill import alike, COMMANDS, GOOD, kill_command  # noqa: E402
from benchmarks.faults.oracle import FAULTS  # noqa: E402
from benchmarks.faults.running import damaged_files, start  # noqa: E402
from benchmarks.faults.scenes import scene_cases  # noqa: E402
from benchmarks.faults.signals import signal_cases  # noqa: E402

_SEED = 41
_CONTENTS, _SCENES, _MACHINES, _SIGNALS = 112, 70, 16, 8


@pytest.fixture(scope='module')
def small_scene(tmp_path_factory):
    from benchmarks.faults.small_scene import make_small_scene

    return make_small_scene(tmp_path_factory.mktemp('small'))


def faults_of(outcomes, count):
    """Return what went wrong among so many cases."""
    found = list(outcomes)
    assert len(found) == count
    return [one for one in found if one.outcome in FAULTS]


def test_odd_messages_are_left_out_and_told(tmp_path):
    assert _CONTENTS % len(CHANGES) == 0
    assert faults_of(content_cases(sample(), tmp_path, _CONTENTS, _SEED), _CONTENTS) == []


def test_the_oracle_of_odd_messages_notices_a_loss(tmp_path, monkeypatch):
    """The judge is worth something: a reader that tells of nothing it left out is found out."""
    from diffcal_ros.recording.recording import Recording

    monkeypatch.setattr(Recording, 'leave_out', lambda self, raw, reason: None)
    found = {one.outcome for one in content_cases(sample(), tmp_path, 40, _SEED)}
    assert 'silent loss' in found


def test_odd_scenes_are_read_or_refused(tmp_path):
    assert faults_of(scene_cases(tmp_path, _SCENES, _SEED), _SCENES) == []


@pytest.mark.slow
def test_odd_machines_get_an_answer(small_scene, tmp_path):
    cases = environment_cases(small_scene, tmp_path, _MACHINES, _SEED)
    assert faults_of(cases, _MACHINES) == []


@pytest.mark.slow
def test_signals_end_commands_in_order(small_scene, tmp_path):
    assert faults_of(signal_cases(small_scene, tmp_path, _SIGNALS, _SEED), _SIGNALS) == []


@pytest.mark.slow
@pytest.mark.parametrize('command', COMMANDS)
def test_killed_commands_leave_whole_files_and_run_again(small_scene, tmp_path, command):
    random = np.random.default_rng(_SEED)
    found = list(kill_command(command, small_scene, tmp_path, 2, random))
    assert [one for one in found if one[0] not in GOOD] == []
    assert ('rerun right', command) in found


@pytest.mark.slow
def test_killed_nodes_return_and_the_others_go_on(small_scene, tmp_path, monkeypatch):
    pytest.importorskip('rclpy', reason='ROS 2 is not installed')
    from benchmarks.faults.kill_nodes import domain_settings, kill_nodes

    random = np.random.default_rng(_SEED)
    # Undone after the test.
    for name, value in domain_settings(random).items():
        monkeypatch.setenv(name, value)
    found = list(kill_nodes(small_scene, tmp_path / 'nodes', 4, random))
    assert [one for one in found if one[0] not in GOOD] == []
    assert ('rerun right', 'nodes') in found


def test_half_a_file_and_who_is_left_are_noticed(tmp_path):
    (tmp_path / 'result.json').write_text('{"outcome": "conv')
    (tmp_path / 'whole.json').write_text('{}')
    (tmp_path / 'report.html').write_text('<html><body>')
    (tmp_path / '.hidden.json').write_text('{')
    assert damaged_files(tmp_path) == ['report.html', 'result.json']
    child = 'import subprocess, sys; subprocess.Popen([sys.executable, "-c", "input()"])'
    waits = 'import time; time.sleep(600)'
    running = start([], tmp_path / 'log', program=child.replace('input()', waits))
    assert running.ends_within(60.0)
    assert len(running.left_running(patience=0.0)) == 1
    running.end()
    assert running.left_running(patience=10.0) == []


def test_documents_are_alike_but_for_time_and_rounding():
    one = {'modulus': 90e3, 'seconds': 3.0, 'gaps': [1.0, float('nan')]}
    assert alike(one, {'modulus': 90e3 * (1 + 1e-9), 'seconds': 4.0, 'gaps': [1.0, float('nan')]})
    assert not alike(one, {**one, 'modulus': 91e3})
    assert not alike(one, {**one, 'gaps': [1.0]})
    assert not alike(one, {'modulus': 90e3})
