# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What was said of all sealed sets of other forms, each by the state that was sealed against it.

    python -m benchmarks.blind.all_sets [--into docs/diagnosis.md]

Counts by set, by sensor, by law of the rubber and by effect, as Markdown, from the answers in
benchmarks/results/blind_*_form_sealed.json; into a page they go between two marks.
"""

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
import json
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.blind.outcomes import CLASS, SAID

RESULTS = Path(__file__).parents[1] / 'results'
# In the order in which they were drawn.
_SETS = (
    *('second', 'third', 'fourth', 'fifth', 'sixth', 'seventh', 'eighth', 'ninth', 'tenth'),
    *('eleventh', 'twelfth', 'thirteenth', 'fourteenth', 'fifteenth', 'sixteenth'),
    *('seventeenth', 'eighteenth', 'nineteenth', 'twentieth', 'twentyfirst', 'twentysecond'),
    *('twentythird', 'twentyfourth', 'twentyfifth', 'twentysixth', 'twentyseventh'),
    *('twentyeighth', 'twentyninth', 'thirtieth', 'thirtyfirst', 'thirtysecond'),
    *('thirtythird', 'thirtyfourth', 'thirtyfifth', 'thirtysixth', 'thirtyseventh'),
    'thirtyeighth',
)
_BEGIN, _END = '<!-- python -m benchmarks.blind.all_sets -->\n', '<!-- end -->\n'
# Outcomes of single effects, in the order of their columns.
_OF_SINGLES = (
    ('named', ('right',)),
    ('named beside another', ('right, and another',)),
    ('one of a set', ('in the set',)),
    ('unknown, its class', ('unknown, right class',)),
    ('unknown, another class', ('unknown, other class',)),
    ('no name', ('no name', 'not seen')),
    ('wrong', ('wrong',)),
)

Row = Mapping[str, Any]


def read_sets(folder: Path = RESULTS) -> dict[str, list[dict[str, Any]]]:
    """Return the answers of all sealed sets of forms by the set's name, in order."""
    found = {}
    for name in _SETS:
        path = folder / f'blind_{name}_form_sealed.json'
        if path.is_file():
            found[name] = json.loads(path.read_text(encoding='utf-8'))['cases']
    return found


def tables(sets: Mapping[str, Sequence[Row]]) -> str:
    """Write all tables, with a blank line between two."""
    every = [row for rows in sets.values() for row in rows]
    return '\n'.join(
        [
            *_counts('set', {**sets, 'all': every}),
            '',
            *_counts('sensor', _grouped(every, lambda row: row['sensor'])),
            '',
            *_counts('law', _grouped(every, lambda row: row.get('law'))),
            '',
            *_by_effect([row for row in every if _kind(row) == 'form']),
        ]
    )


def _kind(row: Row) -> str:
    """Return what a case is: the first sets did not say, and had no causes outside the library."""
    known: str | None = row.get('kind')
    return known or ('clean', 'form', 'pair')[len(row['truth'])]


def _grouped(rows: Iterable[Row], key: Callable[[Row], str | None]) -> dict[str, list[Row]]:
    """Return rows by a key, in its order; those without one are left out."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        if name := key(row):
            found.setdefault(name, []).append(row)
    return dict(sorted(found.items()))


def _counts(by: str, groups: Mapping[str, Sequence[Row]]) -> list[str]:
    """Return a table with the same counts of each group."""
    head = (
        f'by {by}',
        'alarms on clean worlds',
        'wrong names, all faulty',
        'single effects that disagree: named',
        'the same: named, in the set, or its class',
        'outside causes that disagree: unknown or class',
        'pairs: both named',
        'the same: one, and no other',
        'median time [s]',
    )
    return _table(head, ([name, *_cells(rows)] for name, rows in groups.items()))


def _cells(rows: Sequence[Row]) -> list[str]:
    """Return the counts of `_counts`."""
    kinds = _grouped(rows, _kind)
    clean, faulty = kinds.get('clean', []), [row for row in rows if _kind(row) != 'clean']
    seen = [row for row in kinds.get('form', []) if row['verdict'] == 'disagree']
    outside = [row for row in kinds.get('outside', []) if row['verdict'] == 'disagree']
    pairs = kinds.get('pair', [])
    return [
        _share(clean, lambda row: row['outcome'] != 'quiet'),
        _share(faulty, _has_wrong_name),
        _share(seen, lambda row: row['outcome'] == 'right'),
        _share(seen, _tells_truth_or_class),
        _share(outside, lambda row: row['outcome'] != 'wrong'),
        _share(pairs, lambda row: row['outcome'] == 'right'),
        _share(pairs, lambda row: row['outcome'] == 'one of two'),
        f'{median(row["seconds"] for row in rows):.0f}',
    ]


def _share(rows: Sequence[Row], holds: Callable[[Row], bool]) -> str:
    return f'{sum(map(holds, rows))} of {len(rows)}' if rows else '-'


def _has_wrong_name(row: Row) -> bool:
    """Tell whether something is named with some confidence that is not there."""
    truth = {name for name, _ in row['truth']}
    return any(name not in truth for name, confidence in row['said'] if confidence >= SAID)


def _tells_truth_or_class(row: Row) -> bool:
    """Tell whether the one true effect, or its class, is among what is told."""
    ((truth, _),) = row['truth']
    told = row.get('unknown_classes') or [row['unknown_class']]
    return truth in row['set'] or CLASS[truth] in told


def _by_effect(singles: Sequence[Row]) -> list[str]:
    """Return a table of what single effects that disagree were told as."""
    body = []
    for name, rows in _grouped(singles, lambda row: row['truth'][0][0]).items():
        seen = [row['outcome'] for row in rows if row['verdict'] == 'disagree']
        counts = [str(sum(own in those for own in seen)) for _, those in _OF_SINGLES]
        forms = len({form for row in rows for _, form in row['truth']})
        body.append([f'`{name}`', str(forms), *counts, str(len(rows) - len(seen))])
    names = [title for title, _ in _OF_SINGLES]
    return _table(('effect', 'forms', *names, 'below the margin, or not seen'), body)


def _table(head: Sequence[str], body: Iterable[Sequence[str]]) -> list[str]:
    """Return a Markdown table, line by line."""
    return [f'| {" | ".join(cells)} |' for cells in (head, ['---'] * len(head), *body)]


def put_into(page: str, found: str) -> str:
    """Return a page with tables between its marks, in place of what was there.

    Raises:
        ValueError: the page has no such marks.
    """
    before, begin, rest = page.partition(_BEGIN)
    _, end, after = rest.partition(_END)
    if not (begin and end):
        raise ValueError(f'the page needs the lines {_BEGIN.strip()} and {_END.strip()}')
    return f'{before}{begin}\n{found}\n\n{end}{after}'


def main() -> None:
    """Print the tables, or put them into a page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--into', type=Path, metavar='PAGE')
    page = parser.parse_args().into
    found = tables(read_sets())
    if page is None:
        print(found)
    else:
        page.write_text(put_into(page.read_text(encoding='utf-8'), found), encoding='utf-8')


if __name__ == '__main__':
    main()
