# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The nodes as users reach them: ros2 launch, topic, param and lifecycle, where ros2 is there."""

import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import time

import pytest

pytestmark = [
    pytest.mark.skipif(shutil.which('ros2') is None, reason='the command ros2 is not installed'),
    pytest.mark.slow,
]
ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / 'bags' / 'sample'
NODES = ('calibration', 'depth_source', 'marker_pose')
_LIMIT = 300.0  # However slow a machine is: what waits so long has failed [s].
# A daemon would outlive the test; nodes that run already are found within 3 s.
_DIRECT = ('--no-daemon', '--spin-time', '5')


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """An installation of this very tree."""
    prefix = tmp_path / 'installed'
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / 'diffcal_ros').touch()
    for folder in ('config', 'launch', 'rviz'):
        shutil.copytree(ROOT / folder, prefix / 'share' / 'diffcal_ros' / folder)
    programs = prefix / 'lib' / 'diffcal_ros'
    programs.mkdir(parents=True)
    for name in NODES:
        program = programs / name
        program.write_text(
            f'#!{sys.executable}\nimport sys\n'
            f'from diffcal_ros.ros.{name}_node import main\nsys.exit(main())\n'
        )
        program.chmod(0o755)
    before = os.environ.get('AMENT_PREFIX_PATH', '')
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'{prefix}:{sys.prefix}:{before}')
    monkeypatch.setenv('PYTHONPATH', f'{ROOT}:{os.environ.get("PYTHONPATH", "")}')
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path / 'log'))


def _ros2(*words: str) -> str:
    done = subprocess.run(
        ['ros2', *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=_LIMIT,
        check=False,
    )
    return done.stdout


class Launched:
    """`ros2 launch` of the package's file with the sample."""

    def __init__(self, log: Path) -> None:
        self._log = log
        arguments = [f'scene:={SAMPLE / "scene.yaml"}', f'bag:={SAMPLE / "bag"}']
        with log.open('wb') as output:
            self.child = subprocess.Popen(
                ['ros2', 'launch', 'diffcal_ros', 'calibrate.launch.py', *arguments],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def output(self) -> str:
        return self._log.read_text(errors='replace')

    def until(self, words: str) -> None:
        end = time.monotonic() + _LIMIT
        while words not in self.output:
            assert self.child.poll() is None, self.output
            assert time.monotonic() < end, self.output
            time.sleep(0.2)

    def end(self) -> int:
        self.child.send_signal(signal.SIGINT)
        return self.child.wait(_LIMIT)


@pytest.fixture
def launched(installed, tmp_path):
    made = Launched(tmp_path / 'launch.log')
    yield made
    if made.child.poll() is None:
        # SIGTERM would end the launcher and leave its nodes.
        made.end()


def test_launch_goes_on_without_rviz_and_the_result_stays_on_its_topic(launched):
    launched.until('rviz2 is not installed')
    launched.until('the fit converged after')
    assert "Young's modulus 2" in launched.output
    # The recording ended long ago.
    value = _ros2(
        'topic', 'echo', *_DIRECT, '--once', '/calibration/parameters/youngs_modulus/value'
    )
    assert 'data: 2' in value
    assert "'converged'" in _ros2(
        *('topic', 'echo', *_DIRECT, '--once', '--field', 'status', '/calibration/estimates')
    )
    assert 'label: youngs_modulus' in _ros2(
        'topic', 'echo', *_DIRECT, '--once', '/calibration/covariance'
    )
    refused = _ros2('param', 'set', *_DIRECT, '/depth_source', 'bag', '/nowhere')
    assert 'there is no recording /nowhere' in refused
    assert 'Transitioning successful' in _ros2(
        'lifecycle', 'set', *_DIRECT, '/calibration', 'deactivate'
    )
    answer = _ros2(
        'service', 'call', '/calibration/enable', 'std_srvs/srv/SetBool', '{data: true}'
    )
    assert 'ros2 lifecycle set /calibration activate' in answer
    assert launched.end() == 0, launched.output
    for name in NODES:
        assert f'[{name}-' in launched.output
    assert launched.output.count('process has finished cleanly') == len(NODES)
    assert 'Traceback' not in launched.output


@pytest.mark.parametrize(
    ('argument', 'words'),
    [
        ('rate:=fast', "rate is 'fast': use a number"),
        ('loop:=maybe', "loop is 'maybe': use true or false"),
        ('camera:=kinect', "camera is 'kinect': use realsense"),
    ],
)
def test_launch_starts_nothing_where_it_refuses(installed, argument, words):
    said = _ros2(
        'launch', 'diffcal_ros', 'calibrate.launch.py', f'scene:={SAMPLE / "scene.yaml"}', argument
    )
    assert words in said
    assert 'process started' not in said
