# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What was said of effects in other forms than the library's, form by form.

    python -m benchmarks.blind.form_table --verdicts DIR --labels DIR/labels [--seal FILE]
                                          [--out FILE [--salt SALT]]

DIR/<case>/verdict.json are the verdicts. FILE gets every answer, the metrics, and the salt of a
sealed set, with which anybody can make it again.
"""

import argparse
from collections.abc import Mapping, Sequence
import json
from pathlib import Path
import sys
from typing import Any

from benchmarks.blind.answers import Answer
from benchmarks.blind.form_metrics import brier_score, form_metrics, grouped, law_of, reliability
from benchmarks.blind.metric_rows import metric_lines
from benchmarks.blind.outcomes import outcome
from benchmarks.blind.scorer import add_answers, read_answers
from benchmarks.blind.seal import seal_complaint


def table(answers: Sequence[Answer]) -> str:
    """Write one row a case, and the counts, as Markdown."""
    lines = ['| truth, form | sensor, law | answer | gap [mm] | s |', '|---|---|---|---|---|']
    for answer in sorted(answers, key=lambda one: (one.truth, one.label['id'])):
        lines.append('| ' + ' | '.join(_cells(answer)) + ' |')
    counts: dict[str, int] = {}
    for answer in answers:
        counts[outcome(answer)] = counts.get(outcome(answer), 0) + 1
    lines += ['', ', '.join(f'{count} {word}' for word, count in sorted(counts.items()))]
    return '\n'.join(lines) + '\n'


def summary(answers: Sequence[Answer]) -> str:
    """Write metrics, how far confidence is to be relied on, and both by sensor and by law."""
    score, names = brier_score(answers)
    lines = ['', *metric_lines(form_metrics(answers)), '']
    lines += ['| confidence | names | said on average | right |', '|---|---|---|---|']
    for one in reliability(answers):
        lines.append(
            f'| {one["from"]:.1f} to {one["to"]:.1f} | {one["names"]} | {one["said"]:.2f} | '
            f'{one["right"]:.2f} |'
        )
    lines += ['', f'Brier score {score:.2f} over {names} names']
    for by in ('sensor', 'law'):
        groups = grouped(answers, by)
        if not groups:
            continue
        lines += ['', f'| {by} | ' + ' | '.join(one['metric'] for one in groups[0][1]) + ' |']
        lines.append('|---' * (len(groups[0][1]) + 1) + '|')
        for name, rows in groups:
            cells = [f'{one["hits"]} of {one["count"]}' for one in rows]
            lines.append(f'| {name} | ' + ' | '.join(cells) + ' |')
    return '\n'.join(lines) + '\n'


def row(answer: Answer) -> dict[str, Any]:
    """Return what was said of a case beside what it was."""
    verdict = answer.verdict
    return {
        'case': answer.label['id'],
        'truth': [[e['identifier'], _form(e)] for e in answer.label['effects']],
        'kind': answer.label['kind'],
        'sensor': answer.label['sensor'],
        'law': law_of(answer),
        'outcome': outcome(answer),
        'verdict': verdict['verdict'],
        'said': [[e['identifier'], e['confidence']] for e in verdict.get('effects') or ()],
        'set': sorted(answer.reported),
        'unknown_class': verdict.get('unknown_class'),
        'unknown_classes': list(verdict.get('unknown_classes') or ()),
        'gap_mm': [verdict['gap_mm']['nominal'], verdict['gap_mm']['added']],
        'seconds': verdict['seconds'],
    }


def _form(effect: Mapping[str, Any]) -> str | None:
    """Return a true effect's form; a cause outside the library has none."""
    form: str | None = effect['amplitude'].get('form')
    return form


def _cells(answer: Answer) -> tuple[str, ...]:
    verdict = answer.verdict
    forms = [', '.join(filter(None, (e['identifier'], _form(e)))) for e in answer.label['effects']]
    said = [f'{e["identifier"]} {e["confidence"]:.2f}' for e in verdict.get('effects') or ()]
    others = sorted(answer.reported - {e['identifier'] for e in verdict.get('effects') or ()})
    classes = verdict.get('unknown_classes') or filter(None, [verdict.get('unknown_class')])
    words = ' and '.join(said) or ' or '.join(classes)
    if others:
        words += f' (or {", ".join(others)})'
    gap = verdict['gap_mm']
    return (
        f'{" and ".join(forms) or "clean"} ({answer.label["id"]})',
        ', '.join(filter(None, (answer.label['sensor'], law_of(answer)))),
        f'**{outcome(answer)}**: {verdict["verdict"]} {words}'.rstrip(),
        f'{gap["nominal"]:.2f} -> {gap["added"]:.2f}',
        f'{verdict["seconds"]:.0f}',
    )


def main(arguments: list[str] | None = None) -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_answers(parser)
    parser.add_argument('--out', type=Path)
    parser.add_argument('--salt', default='')
    given = parser.parse_args(arguments)
    if complaint := seal_complaint(given.labels, given.seal):
        print(complaint, file=sys.stderr)
        return 2
    answers, missing = read_answers(given.verdicts, given.labels)
    print(table(answers) + summary(answers), end='')
    if given.out is not None:
        rows = [row(answer) for answer in answers]
        score, names = brier_score(answers)
        found = {
            'salt': given.salt,
            'metrics': form_metrics(answers),
            'reliability': reliability(answers),
            'brier': {'score': score if names else None, 'names': names},
            'groups': {by: dict(grouped(answers, by)) for by in ('sensor', 'law')},
            'cases': rows,
        }
        given.out.write_text(json.dumps(found, indent=1) + '\n')
    if missing:
        print(f'{len(missing)} cases have no verdict')
    return 0


if __name__ == '__main__':
    sys.exit(main())
