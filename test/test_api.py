# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The public names: there, described, and loaded only when they are used."""

import ast
import inspect
from pathlib import Path
import subprocess
import sys
import time

import diffcal_ros
import pytest

ROOT = Path(__file__).resolve().parents[1]
NAMES = sorted(set(diffcal_ros.__all__) - {'__version__'})
HEAVY = ('numpy', 'scipy', 'warp', 'torch', 'rclpy', 'cv2', 'matplotlib', 'yaml')
LONGEST_IMPORT = 0.3  # [s]; it takes some 0.02, without the interpreter's own start.


def test_types_of_the_public_names_are_those_that_are_loaded():
    """Checkers read imports that never run: they must name the same homes."""
    tree = ast.parse(Path(diffcal_ros.__file__).read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = {
        alias.name: node.module.removeprefix('diffcal_ros.')
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }
    assert seen == diffcal_ros._HOMES


@pytest.mark.parametrize('name', NAMES)
def test_each_is_there_and_described(name):
    found = getattr(diffcal_ros, name)
    assert found.__name__ == name
    assert inspect.getdoc(found)
    assert name in dir(diffcal_ros)


@pytest.mark.parametrize('name', NAMES)
def test_each_stands_on_the_page_of_the_api(name):
    page = (ROOT / 'docs' / 'api.md').read_text()
    assert f'::: diffcal_ros.{diffcal_ros._HOMES[name]}.{name}\n' in page


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match='calibrated'):
        _ = diffcal_ros.calibrated


def test_importing_the_package_is_quick_and_brings_nothing_along():
    code = (
        'import time; start = time.perf_counter(); import diffcal_ros, sys; '
        'print(time.perf_counter() - start, *sys.modules)'
    )
    shortest = float('inf')
    until = time.monotonic() + 20.0  # A busy machine is given some tries.
    while shortest > LONGEST_IMPORT and time.monotonic() < until:
        done = subprocess.run(
            [sys.executable, '-c', code], capture_output=True, text=True, cwd=ROOT, check=True
        )
        seconds, *modules = done.stdout.split()
        shortest = min(shortest, float(seconds))
        assert not set(modules) & set(HEAVY)
    assert shortest <= LONGEST_IMPORT
