# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The core must not drag ROS, OpenCV or torch along, and imports go one way (.importlinter)."""

from pathlib import Path
import subprocess
import sys

import pytest

ROOT = Path(__file__).resolve().parents[1]


def test_imports_go_one_way() -> None:
    pytest.importorskip('importlinter', reason='import-linter is not installed')
    code = 'from importlinter import cli; raise SystemExit(cli.lint_imports(no_cache=True))'
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ('module', 'absent'),
    [
        ('diffcal_ros.calibration.calibrate', ('rclpy', 'cv2', 'torch', 'rosbags', 'matplotlib')),
        ('diffcal_ros.scene.load', ('rclpy', 'cv2', 'torch', 'rosbags')),
        ('diffcal_ros.cli.main', ('rclpy', 'cv2', 'torch', 'warp', 'matplotlib', 'scipy')),
    ],
)
def test_importing_the_core_brings_nothing_heavy_along(
    module: str, absent: tuple[str, ...]
) -> None:
    code = (
        f'import sys, {module}; sys.exit(",".join(n for n in {absent!r} if n in sys.modules) or 0)'
    )
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 0, f'{module} brought along {done.stderr}'
