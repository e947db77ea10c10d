# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The example scene with one entry replaced by what nobody meant to write."""

from collections.abc import Iterator
import copy
import datetime
from pathlib import Path
from typing import Any

import yaml

EXAMPLE = Path(__file__).resolve().parents[2] / 'config' / 'example_scene.yaml'
NAN, INF = float('nan'), float('inf')
Place = tuple[str | int, ...]

DAMAGE: tuple[Any, ...] = (
    *(None, True, '', [], {}, [[]], {'': None}, {1: 2}),
    *(NAN, INF, -INF, 0, -1, 0.5, 1e-300, -1e300, 10**30, 10**4000, 2**63),
    *('text', 'é☃', '\ud800', '\udcff', 'a\nb', '~nosuchuser/x', 'x' * 300, '\0', '/dev/zero'),
    *(b'bytes', datetime.date(2026, 1, 1), {'a', 'b'}, [NAN, INF, 'x'], [1e300, 1e300, 1e300]),
    *([0, 0, 0], [1], [[1, 2, 3]], list(range(1000)), {'start': 1e-300, 'min': 1e300}, '1e999'),
)


def places(node: Any, place: Place = ()) -> Iterator[Place]:
    """List every key and every item of a document."""
    pairs: Any = ()
    if isinstance(node, dict):
        pairs = node.items()
    elif isinstance(node, list):
        pairs = enumerate(node)
    for key, value in pairs:
        yield (*place, key)
        yield from places(value, (*place, key))


def example() -> dict[str, Any]:
    """Return the example as YAML reads it."""
    document: dict[str, Any] = yaml.safe_load(EXAMPLE.read_text(encoding='utf-8'))
    return document


def damaged(document: dict[str, Any], place: Place, value: Any) -> dict[str, Any]:
    """Return a copy with one entry replaced."""
    changed = copy.deepcopy(document)
    node: Any = changed
    for key in place[:-1]:
        node = node[key]
    node[place[-1]] = value
    return changed
