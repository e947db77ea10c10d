# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What was said of effects in other forms than the library's, form by form.

    python -m benchmarks.blind.form_table --verdicts DIR --labels DIR/labels [--seal FILE]
                                          [--out FILE [--salt SALT]]

DIR/<case>/verdict.json are the verdicts. FILE gets every answer, and the salt of a
sealed set, with which anybody can make it again.
"""

import argparse
from collections.abc import Sequence
import json
from pathlib import Path
import sys
from typing import Any

import numpy as np

from benchmarks.blind.answers import Answer
from benchmarks.blind.scorer import add_answers, read_answers
from benchmarks.blind.seal import seal_complaint

# A name from this confidence on is taken for one.
_SAID = 0.6
# Which part of the world an effect belongs to.
_CLASS = {
    'camera_offset': 'sensor',
    'depth_affine': 'sensor',
    'depth_bias_by_region': 'sensor',
    'gravity_tilt': 'load',
    'added_mass': 'load',
    'contact_plane': 'load',
    'clamp_offset': 'boundary',
    'compliant_clamp': 'boundary',
    'rest_curvature': 'shape',
    'stiffness_contrast': 'material',
    'strain_stiffening': 'material',
}


def outcome(answer: Answer) -> str:
    """Say how right an answer is, in a few words."""
    said = [e for e in answer.verdict.get('effects') or () if float(e['confidence']) >= _SAID]
    names = {effect['identifier'] for effect in said}
    truth = set(answer.truth)
    if not truth:
        return _of_clean(answer, names)
    if names and names == truth:
        return 'right'
    if names > truth:
        return 'right, and another'
    if names:
        return 'wrong'
    if truth <= answer.reported:
        return 'in the set'
    if answer.verdict.get('unknown_class'):
        is_class = answer.verdict['unknown_class'] in {_CLASS[name] for name in truth}
        return 'unknown, right class' if is_class else 'unknown, other class'
    return 'not seen' if answer.verdict['verdict'] == 'agree' else 'no name'


def _of_clean(answer: Answer, names: set[str]) -> str:
    if answer.is_alarm:
        return 'alarm'
    return 'wrong' if names else 'quiet'


def brier_score(answers: Sequence[Answer]) -> tuple[float, int]:
    """Return the mean square of confidence less truth over all names, and their number."""
    squares = [
        (float(effect['confidence']) - (effect['identifier'] in answer.truth)) ** 2
        for answer in answers
        for effect in answer.verdict.get('effects') or ()
    ]
    return (float(np.mean(squares)) if squares else float('nan')), len(squares)


def table(answers: Sequence[Answer]) -> str:
    """Write one row a case, and the counts, as Markdown."""
    lines = ['| truth, form | sensor | answer | gap [mm] | s |', '|---|---|---|---|---|']
    for answer in sorted(answers, key=lambda one: (one.truth, one.label['id'])):
        lines.append('| ' + ' | '.join(_cells(answer)) + ' |')
    counts: dict[str, int] = {}
    for answer in answers:
        counts[outcome(answer)] = counts.get(outcome(answer), 0) + 1
    score, names = brier_score(answers)
    lines += ['', ', '.join(f'{count} {word}' for word, count in sorted(counts.items()))]
    lines.append(f'Brier score {score:.2f} over {names} names')
    return '\n'.join(lines) + '\n'


def row(answer: Answer) -> dict[str, Any]:
    """Return what was said of a case beside what it was."""
    verdict = answer.verdict
    return {
        'case': answer.label['id'],
        'truth': [[e['identifier'], e['amplitude']['form']] for e in answer.label['effects']],
        'sensor': answer.label['sensor'],
        'outcome': outcome(answer),
        'verdict': verdict['verdict'],
        'said': [[e['identifier'], e['confidence']] for e in verdict.get('effects') or ()],
        'set': sorted(answer.reported),
        'unknown_class': verdict.get('unknown_class'),
        'gap_mm': [verdict['gap_mm']['nominal'], verdict['gap_mm']['added']],
        'seconds': verdict['seconds'],
    }


def _cells(answer: Answer) -> tuple[str, ...]:
    verdict = answer.verdict
    forms = [f'{e["identifier"]}, {e["amplitude"]["form"]}' for e in answer.label['effects']]
    said = [f'{e["identifier"]} {e["confidence"]:.2f}' for e in verdict.get('effects') or ()]
    others = sorted(answer.reported - {e['identifier'] for e in verdict.get('effects') or ()})
    words = ' and '.join(said) or verdict.get('unknown_class') or ''
    if others:
        words += f' (or {", ".join(others)})'
    gap = verdict['gap_mm']
    return (
        f'{" and ".join(forms) or "clean"} ({answer.label["id"]})',
        answer.label['sensor'],
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
    print(table(answers), end='')
    if given.out is not None:
        rows = [row(answer) for answer in answers]
        given.out.write_text(json.dumps({'salt': given.salt, 'cases': rows}, indent=1) + '\n')
    if missing:
        print(f'{len(missing)} cases have no verdict')
    return 0


if __name__ == '__main__':
    sys.exit(main())
