# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The generator shares no code with what it tests."""

import ast
from pathlib import Path
import subprocess
import sys

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / 'benchmarks' / 'blind').rglob('*.py'))
PACKAGE = 'diffcal_ros'


def _imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            # A relative import may lead anywhere: its dots stay, and no name may begin with one.
            names.add('.' * node.level + (node.module or ''))
        elif isinstance(node, ast.Call) and getattr(node.func, 'id', '') == '__import__':
            names.add(PACKAGE)
    return names


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_no_module_imports_the_package(path: Path) -> None:
    for name in _imported(path):
        head = name.split('.')[0]
        assert head not in ('', PACKAGE, 'importlib'), name
        # Of this repository only the generator's own folder may be used.
        assert head != 'benchmarks' or name.startswith('benchmarks.blind'), name


def test_nothing_brings_the_package_along() -> None:
    modules = ','.join(f'benchmarks.blind.{path.stem}' for path in FILES if path.stem[0] != '_')
    code = f'import {modules}, sys; sys.exit("{PACKAGE}" in sys.modules)'
    assert subprocess.run([sys.executable, '-c', code], cwd=ROOT, check=False).returncode == 0
