# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a test asserts it asserts always: under a condition it may never be asked."""

import ast
from pathlib import Path

FILES = sorted(Path(__file__).parent.rglob('*.py'))


def _conditional_asserts(source: str) -> list[int]:
    """Return the lines of asserts that run only in some branch."""
    branches = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.If)]
    return sorted(
        {node.lineno for branch in branches for node in ast.walk(branch) if _asserts(node)}
    )


def _asserts(node: ast.AST) -> bool:
    is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    return isinstance(node, ast.Assert) or (
        is_call and (node.func.attr == 'raises' or node.func.attr.startswith('assert_'))
    )


def test_no_assert_stands_under_a_condition() -> None:
    found = {
        file.name: lines for file in FILES if (lines := _conditional_asserts(file.read_text()))
    }
    assert found == {}


def test_those_that_do_are_found() -> None:
    source = 'if x:\n    assert y\nelse:\n    with pytest.raises(E):\n        f()\nassert z\n'
    assert _conditional_asserts(source) == [2, 4]
