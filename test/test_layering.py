# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The core must not drag ROS, OpenCV or torch along, and imports go one way (.importlinter)."""

import ast
from pathlib import Path
import subprocess
import sys

from diffcal_ros.effects.registry import EFFECTS
import pytest

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / 'diffcal_ros'


def test_imports_go_one_way() -> None:
    pytest.importorskip('importlinter', reason='import-linter is not installed')
    code = 'from importlinter import cli; raise SystemExit(cli.lint_imports(no_cache=True))'
    done = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def _texts(path: Path) -> set[str]:
    """Return the strings of a module; those of an enumeration are names of its own."""
    tree = ast.parse(path.read_text())
    own = [
        n
        for c in ast.walk(tree)
        if isinstance(c, ast.ClassDef) and c.name == 'Kind'
        for n in ast.walk(c)
    ]
    return {
        node.value.partition('.')[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in own
    }


@pytest.mark.parametrize('package', ['diagnosis', 'calibration', 'report'])
def test_nobody_asks_which_effect_it_is(package: str) -> None:
    found = {
        str(path.relative_to(LIBRARY)): named
        for path in sorted((LIBRARY / package).rglob('*.py'))
        if (named := _texts(path) & set(EFFECTS))
    }
    assert not found, f'an effect says itself what is special about it: {found}'


@pytest.mark.parametrize(
    ('module', 'absent'),
    [
        ('diffcal_ros.calibration.calibrate', ('rclpy', 'cv2', 'torch', 'rosbags', 'matplotlib')),
        ('diffcal_ros.scene.load', ('rclpy', 'cv2', 'torch', 'rosbags')),
        ('diffcal_ros.cli.main', ('rclpy', 'cv2', 'torch', 'warp', 'matplotlib', 'scipy')),
    ],
)
@pytest.mark.slow_but_first
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
