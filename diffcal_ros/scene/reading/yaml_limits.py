# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much a YAML file may hold: a few aliases of aliases stand for more than memory does."""

from pathlib import Path

from diffcal_ros.errors import SceneError
import yaml

MOST_BYTES = 10_000_000
# Of everything in the file, with what an alias stands for counted each time that it is used.
_MOST_ENTRIES = 1_000_000
_DEEPEST = 40


def require_limits(path: Path, root: yaml.Node) -> None:
    """Refuse a document that is too large or too deep, before anything is made of it.

    Raises:
        SceneError: saying which limit is passed.
    """
    if _size(path, root, {}, 0) > _MOST_ENTRIES:
        raise SceneError(
            f'{path} stands for more than {_MOST_ENTRIES:,} entries, aliases counted each time: '
            'write what is meant without aliases of aliases'
        )


def _size(path: Path, node: yaml.Node, known: dict[int, int], depth: int) -> int:
    """Count a node and what is below it; `known` holds 0 for those that are being counted."""
    if not isinstance(node, yaml.CollectionNode):
        return 1
    if depth > _DEEPEST:
        raise SceneError(f'{path} is nested more than {_DEEPEST} deep: give a scene file')
    if id(node) not in known:
        known[id(node)] = 0
        items = [item for pair in node.value for item in pair] if _is_map(node) else node.value
        known[id(node)] = 1 + sum(_size(path, item, known, depth + 1) for item in items)
    elif not known[id(node)]:
        line = node.start_mark.line + 1
        raise SceneError(f'{path}, line {line}: it contains itself by an alias: write it out')
    return known[id(node)]


def _is_map(node: yaml.Node) -> bool:
    return isinstance(node, yaml.MappingNode)
