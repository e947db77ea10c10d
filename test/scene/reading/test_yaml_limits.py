# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A small file must not stand for more than memory holds."""

from diffcal_ros.errors import SceneError
from diffcal_ros.scene.reading.yaml_document import read_yaml
import pytest

_LEVELS = 30


def _bomb(item: str) -> str:
    lines = [f'a0: &a0 {item}']
    for level in range(1, _LEVELS):
        before = ', '.join([f'*a{level - 1}'] * 9)
        lines.append(f'a{level}: &a{level} [{before}]')
    return '\n'.join(lines)


def _merges() -> str:
    lines = ['a0: &a0 {x: 1}']
    for level in range(1, _LEVELS):
        lines.append(f'a{level}: &a{level} {{<<: [*a{level - 1}, *a{level - 1}, *a{level - 1}]}}')
    return '\n'.join(lines)


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        (_bomb('[x, x]'), 'stands for more than 1,000,000 entries, aliases counted each time'),
        (_merges(), 'stands for more than 1,000,000 entries'),
        ('a: ' + '[' * 60 + ']' * 60, 'nested more than 40 deep'),
        ('a: ' + '[' * 100_000, 'is nested too deeply'),
        ('a: &a [1, *a]', 'line 1: it contains itself by an alias: write it out'),
        ('a: &a {b: {c: *a}}', 'contains itself by an alias'),
    ],
    ids=['lists', 'merges', 'deep', 'very deep', 'list in itself', 'mapping in itself'],
)
@pytest.mark.slow_but_first
def test_bombs_are_refused(tmp_path, text, sentence):
    path = tmp_path / 'scene.yaml'
    path.write_text(text)
    with pytest.raises(SceneError, match=sentence):
        read_yaml(path)


def test_honest_aliases_are_read(tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text('a: &a {x: [1, 2]}\nb: *a\nc: {<<: *a, y: 3}')
    assert read_yaml(path).content['c'] == {'x': [1, 2], 'y': 3}
