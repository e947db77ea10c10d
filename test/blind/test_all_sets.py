# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""All sealed sets counted together, and the page that says so."""

from pathlib import Path
from typing import Any

import pytest

from benchmarks.blind.all_sets import put_into, read_sets, tables

PAGE = Path(__file__).parents[2] / 'docs' / 'diagnosis.md'


def _row(kind: str, outcome: str, truth: tuple[str, ...] = (), **more: Any) -> dict[str, Any]:
    """Return an answer as a result file has it."""
    known = {
        'kind': kind,
        'outcome': outcome,
        'truth': [[name, f'form of {name}'] for name in truth],
        'sensor': 'd405',
        'law': 'plain',
        'verdict': 'disagree' if truth else 'agree',
        'said': [],
        'set': [],
        'unknown_class': None,
        'seconds': 10.0,
    }
    return {**known, **more}


ROWS = (
    _row('clean', 'quiet'),
    _row('clean', 'alarm', seconds=30.0),
    _row('form', 'right', ('added_mass',), said=[['added_mass', 0.8]], set=['added_mass']),
    _row('form', 'wrong', ('added_mass',), said=[['clamp_offset', 0.8]], set=['clamp_offset']),
    _row('form', 'unknown, other class', ('added_mass',), unknown_classes=['shape', 'load']),
    _row('form', 'no name', ('added_mass',), verdict='below_margin', seconds=40.0),
    _row('form', 'in the set', ('gravity_tilt',), set=['gravity_tilt'], sensor='itof'),
    # What is said with less than 0.6 is no name.
    _row('outside', 'unknown, right class', ('magnet',), said=[['gravity_tilt', 0.5]]),
    _row('outside', 'wrong', ('magnet',), said=[['gravity_tilt', 0.7]]),
    _row('pair', 'one of two', ('added_mass', 'gravity_tilt'), said=[['gravity_tilt', 0.7]]),
)


def _cells(found: str, first: str) -> list[str]:
    (line,) = (line for line in found.splitlines() if line.startswith(f'| {first} |'))
    return [cell.strip() for cell in line.strip('|').split('|')][1:]


def test_answers_are_counted():
    found = tables({'one': ROWS[:4], 'two': ROWS[4:]})
    assert _cells(found, 'all') == [
        *('1 of 2', '2 of 8', '1 of 4', '3 of 4', '1 of 2', '0 of 1', '1 of 1', '10')
    ]
    assert _cells(found, 'one') == ['1 of 2', '1 of 2', '1 of 2', '1 of 2', '-', '-', '-', '10']
    assert _cells(found, 'itof') == ['-', '0 of 1', '0 of 1', '1 of 1', '-', '-', '-', '10']
    # Forms, named, beside another, one of a set, its class, another, no name, wrong, not seen.
    assert _cells(found, '`added_mass`') == ['1', '1', '0', '0', '0', '1', '0', '1', '1']
    assert _cells(found, '`gravity_tilt`') == ['1', '0', '0', '1', '0', '0', '0', '0', '0']


def test_what_a_case_is_follows_from_its_truth_where_it_is_not_said():
    rows = [{**row, 'kind': None, 'law': None} for row in ROWS if row['kind'] != 'outside']
    found = tables({'old': rows})
    assert _cells(found, 'old')[:3] == ['1 of 2', '1 of 6', '1 of 4']
    assert 'by law' in found
    assert '| plain |' not in found


def test_tables_take_the_place_of_older_ones():
    page = 'Before.\n<!-- python -m benchmarks.blind.all_sets -->\nold\n<!-- end -->\nAfter.\n'
    once = put_into(page, '| new |')
    assert 'old' not in once
    assert once.startswith('Before.\n')
    assert once.endswith('After.\n')
    assert put_into(once, '| new |') == once
    with pytest.raises(ValueError, match='needs the lines'):
        put_into('Before.\n', '| new |')


def test_the_page_counts_all_results():
    """`python -m benchmarks.blind.all_sets --into docs/diagnosis.md` after a new set."""
    page = PAGE.read_text(encoding='utf-8')
    assert put_into(page, tables(read_sets())) == page
