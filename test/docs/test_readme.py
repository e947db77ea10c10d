# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the README promises: outcomes, exit codes, a scene that can be read, Python that runs."""

import ast
from pathlib import Path
import re

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.cli.main import make_parser
from diffcal_ros.scene.schema import scene_schema
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / 'README.md').read_text(encoding='utf-8')
PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').glob('*.md'))]
# Five minutes of reading.
MOST_LINES = 150
INTERRUPTED = 130


def _fences(text: str, language: str) -> list[str]:
    found = re.findall(r'^```([^\n`]*)\n(.*?)^```$', text, re.MULTILINE | re.DOTALL)
    return [content for given, content in found if given == language]


def test_it_is_read_in_five_minutes():
    assert len(README.splitlines()) <= MOST_LINES


def test_every_outcome_stands_there_with_its_exit_code():
    rows = dict(re.findall(r'^\| `(\w+)` \| (\d+) \|', README, re.MULTILINE))
    codes = {outcome.value: outcome.exit_code for outcome in Outcome}
    codes[Outcome.INTERRUPTED.value] = INTERRUPTED
    assert {name: int(code) for name, code in rows.items()} == codes


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_scenes_are_valid(page):
    jsonschema = pytest.importorskip('jsonschema')
    for text in _fences(page.read_text(encoding='utf-8'), 'yaml'):
        section = yaml.safe_load(text)
        if 'bodies' in (section or {}):
            continue  # A manifest, which test/batch/test_manifest.py reads.
        schema = scene_schema()
        if 'format' not in (section or {}):
            # A part of a scene: its regions may lack what the whole one states.
            schema.pop('required')
        jsonschema.Draft7Validator(schema).validate(section or {})


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_python_can_be_read(page):
    for text in _fences(page.read_text(encoding='utf-8'), 'python'):
        ast.parse(text)


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_commands_are_known(page):
    for command in _commands(page):
        make_parser().parse_args(command)


def test_commands_are_found():
    assert [command[0] for command in _commands(ROOT / 'README.md')] == [
        'calibrate',
        'check',
        'calibrate',
        'calibrate',
        'export',
    ]


def _commands(page: Path) -> list[list[str]]:
    """Return lines that are commands, without what a comment says."""
    blocks = '\n'.join(_fences(page.read_text(encoding='utf-8'), ''))
    lines = re.findall(r'^(?:\$ )?diffcal (.*)$', blocks, re.MULTILINE)
    return [line.partition(' #')[0].split() for line in lines]
