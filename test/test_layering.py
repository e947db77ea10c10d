# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The core must not drag ROS, OpenCV or torch along, and imports go one way."""

import ast
from pathlib import Path
import subprocess
import sys

from diffcal_ros.effects.library import EFFECTS
import pytest

ROOT = Path(__file__).resolve().parents[1] / 'diffcal_ros'
# Who may import whom: a package may import those listed, and the nouns at the top.
ALLOWED = {
    'effects': {'fem'},
    'scene': {'fem', 'effects'},
    'fem': set(),
    'depth': set(),
    'pose': set(),
    'calibration': {'fem', 'depth', 'effects', 'scene'},
    'recording': {'scene', 'pose', 'calibration', 'depth', 'fem'},
    'observing': {'pose', 'calibration', 'depth', 'fem', 'scene'},
    'synthetic': {'recording', 'pose', 'calibration', 'depth', 'fem', 'effects', 'scene'},
    'diagnosis': {'calibration', 'fem', 'depth', 'effects', 'scene', 'recording'},
    'reproduction': {
        'offline',
        'synthetic',
        'recording',
        'calibration',
        'depth',
        'fem',
        'scene',
    },
    'planning': {'synthetic', 'calibration', 'fem', 'depth', 'scene'},
    'report': {
        'effects',
        'planning',
        'reproduction',
        'diagnosis',
        'calibration',
        'fem',
        'depth',
        'scene',
        'recording',
    },
    'prediction': {
        'report',
        'synthetic',
        'recording',
        'calibration',
        'fem',
        'depth',
        'effects',
        'scene',
    },
}
NOUN_PACKAGES = {'scene'}
HEAVY = {
    'rclpy': {'ros'},
    'cv2': {'pose', 'recording'},
    'torch': {'calibration'},
    'rosbags': {'recording'},
    'mcap': {'recording'},
}


def _imports(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
            names.update(f'{node.module}.{alias.name}' for alias in node.names)
    return names


def _package(path: Path) -> str:
    relative = path.relative_to(ROOT)
    return relative.parts[0] if len(relative.parts) > 1 else ''


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


FILES = sorted(ROOT.rglob('*.py'))


@pytest.mark.parametrize('path', FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_imports_go_one_way(path: Path) -> None:
    package = _package(path)
    if package not in ALLOWED:
        return
    for name in _imports(path):
        parts = name.split('.')
        if parts[0] != 'diffcal_ros' or len(parts) < 2 or not (ROOT / parts[1]).is_dir():
            continue
        assert parts[1] in {package, *ALLOWED[package]}, f'{package} must not import {name}'


@pytest.mark.parametrize('package', ['diagnosis', 'calibration', 'report'])
def test_nobody_asks_which_effect_it_is(package: str) -> None:
    found = {
        str(path.relative_to(ROOT)): named
        for path in sorted((ROOT / package).rglob('*.py'))
        if (named := _texts(path) & set(EFFECTS))
    }
    assert not found, f'an effect says itself what is special about it: {found}'


@pytest.mark.parametrize('path', FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_heavy_libraries_stay_where_they_belong(path: Path) -> None:
    found = {name.split('.')[0] for name in _imports(path)} & set(HEAVY)
    wrong = {name for name in found if _package(path) not in HEAVY[name]}
    assert not wrong, f'{wrong} may be imported in {[HEAVY[name] for name in wrong]} only'


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
        [sys.executable, '-c', code], capture_output=True, text=True, cwd=ROOT.parent, check=False
    )
    assert done.returncode == 0, f'{module} brought along {done.stderr}'
