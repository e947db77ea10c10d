# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Score verdicts against labels.

    python -m benchmarks.blind.scorer --verdicts DIR --labels DIR/labels --out DIR [--seal FILE]

DIR/<case>/verdict.json are the verdicts. Beside the documented keys a verdict may publish, by
effect, `times_detectable` (expected amplitude over the smallest detectable one) and
`largest_cosine`; where it does not, no case is left out of the naming score. An effect can be seen
where the first is 1 at least.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
import json
from pathlib import Path
import sys
from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import LIBRARY, MOTION
from benchmarks.blind.answers import Answer
from benchmarks.blind.labels import write_json
from benchmarks.blind.metric_rows import median, metric_lines, row, share
from benchmarks.blind.seal import seal_complaint

COLUMNS = (*LIBRARY, *MOTION, 'unknown', 'agree', 'abstain')
_CLEAR, _TWIN = 3.0, 0.95


def add_answers(parser: argparse.ArgumentParser) -> None:
    """Add the options that say where verdicts, labels and their seal are."""
    parser.add_argument('--verdicts', type=Path, required=True)
    parser.add_argument('--labels', type=Path, required=True)
    parser.add_argument('--seal', type=Path, help='hashes of the labels, made before the run')


def read_answers(verdicts: Path, labels: Path) -> tuple[list[Answer], list[str]]:
    """Return all answered cases, and the names of those without a verdict."""
    answers, missing = [], []
    for file in sorted(labels.glob('*.json')):
        verdict = verdicts / file.stem / 'verdict.json'
        if not verdict.is_file():
            missing.append(file.stem)
            continue
        answers.append(Answer(json.loads(file.read_text()), json.loads(verdict.read_text())))
    return answers, missing


def score(answers: Sequence[Answer]) -> list[dict[str, Any]]:
    """Return the table of metrics: name, value, count, and what ships and what is reached for."""
    clean, single, pair, outside, denied = (
        [answer for answer in answers if answer.label['kind'] == kind]
        for kind in ('clean', 'single', 'pair', 'outside', 'denied')
    )
    faulty = [*single, *pair, *outside, *denied]
    library = [*single, *pair]
    clear = [answer for answer in single if _is_clear(answer)]
    unseen = [a for a in library if a.verdict['verdict'] in ('agree', 'below_margin')]
    seen = [answer for answer in library if answer not in unseen]
    detectable = [answer for answer in single if (answer.times_detectable() or 0.0) >= 1.0]
    alarming = [answer for answer in outside if answer.is_alarm]
    unknown = [answer for answer in outside if answer.is_unknown]
    rows = [
        share('false alarms on clean data', clean, lambda a: a.is_alarm, '<= 1 %', '0 of 300'),
        share('right name, clear cases', clear, lambda a: a.is_right, '>= 85 %', '>= 97 %'),
        share('the same, named below the margin too', clear, lambda a: a.is_told_right, '', ''),
        share('truth in the reported set, all', library, _holds_truth, '>= 95 %', '>= 99 %'),
        share('the same, where a gap is reported', seen, _holds_truth, '', ''),
        share('the same, of single effects that can be seen', detectable, _holds_truth, '', ''),
        median('size of the reported set', [float(len(a.reported)) for a in seen], '', '1'),
        share(
            'confident wrong name', faulty, lambda a: a.is_confidently_wrong, '<= 3 %', '<= 0.5 %'
        ),
        share('outside called unknown', outside, lambda a: a.is_unknown, '>= 80 %', '>= 95 %'),
        share('the same, of those with a gap', alarming, lambda a: a.is_unknown, '', ''),
        share('the same, told below the margin too', outside, lambda a: a.is_told_unknown, '', ''),
        share('class of the unknown right', unknown, _has_class, '', '>= 80 %'),
        share('denied effect not misnamed', denied, lambda a: not a.named, '', ''),
        share('both of two named', pair, lambda a: a.is_right, '60 %', '90 %'),
    ]
    return rows + _sizes(single)


def _sizes(single: Sequence[Answer]) -> list[dict[str, Any]]:
    """Return the rows about amplitudes, closure and the modulus."""
    closures = [a.verdict.get('closure') for a in single if a.named]
    known = [100.0 * float(value) for value in closures if value is not None]
    scores = [found for a in single if (found := a.amplitude_score()) is not None]
    covered = [hit for _, hits in scores for hit in hits]
    moduli = [e for a in single if a.named and (e := a.modulus_errors()) is not None]
    before, after = (np.array([pair[i] for pair in moduli]) for i in range(2))
    tenth = float(np.percentile(known, 10)) if known else float('nan')
    ratio = float(np.median(after) / np.median(before)) if len(moduli) else float('nan')
    return [
        median('held-out closure, median [%]', known, '80', '95'),
        row('held-out closure, 10th percentile [%]', tenth, len(known), '50', '90'),
        median('amplitude error [%]', [100.0 * error for error, _ in scores], '15', '5'),
        row(
            'coverage of the 95 % interval [%]',
            100.0 * float(np.mean(covered)) if covered else float('nan'),
            len(covered),
            '90-98',
            '90-98',
        ),
        median('error of E, nominal [%]', (100.0 * before).tolist(), '', ''),
        median('error of E, added [%]', (100.0 * after).tolist(), '', ''),
        row('error of E, added over nominal', ratio, len(moduli), '1/3', '1/10'),
    ]


def _is_clear(answer: Answer) -> bool:
    times, cosine = answer.times_detectable(), answer.largest_cosine()
    return (times is None or times >= _CLEAR) and (cosine is None or cosine < _TWIN)


def _holds_truth(answer: Answer) -> bool:
    return set(answer.truth) <= answer.reported


def _has_class(answer: Answer) -> bool:
    return bool(answer.verdict.get('unknown_class') == answer.label['outside_class'])


def confusion(answers: Sequence[Answer]) -> dict[str, dict[str, int]]:
    """Count answers by truth; pairs are left out, since they have two."""
    matrix: dict[str, Counter[str]] = {}
    for answer in answers:
        kind = answer.label['kind']
        if kind == 'pair':
            continue
        truth = answer.truth[0] if kind == 'single' else kind
        matrix.setdefault(truth, Counter())[answer.column] += 1
    return {truth: dict(counts) for truth, counts in matrix.items()}


def failures(answers: Sequence[Answer]) -> list[dict[str, Any]]:
    """List every case that is not right: false alarms, other names, none."""
    found = []
    for answer in answers:
        kind = answer.label['kind']
        wrong = {
            'clean': answer.is_alarm,
            'outside': not answer.is_unknown,
            'denied': bool(answer.named),
        }.get(kind, not answer.is_right)
        if wrong:
            found.append(
                {
                    'case': answer.label['id'],
                    'kind': kind,
                    'poses': len(answer.label['poses']),
                    'family': answer.label['family'],
                    'truth': list(answer.truth),
                    'sizes': answer.label['sizes'],
                    'verdict': answer.verdict['verdict'],
                    'answer': answer.column,
                    'reported': sorted(answer.reported),
                    'is_confidently_wrong': answer.is_confidently_wrong,
                }
            )
    return found


def shuffled(answers: Sequence[Answer], seed: int = 0) -> list[Answer]:
    """Give single-effect verdicts the labels of others: naming must fall to chance."""
    single = [answer for answer in answers if answer.label['kind'] == 'single']
    order = np.random.default_rng(seed).permutation(len(single))
    return [Answer(single[i].label, case.verdict) for i, case in zip(order, single, strict=True)]


def report_text(rows: Sequence[dict[str, Any]], matrix: dict[str, dict[str, int]]) -> str:
    """Write the metrics and the confusion matrix as Markdown."""
    lines = metric_lines(rows)
    lines += ['', '| truth | ' + ' | '.join(COLUMNS) + ' |', '|---' * (len(COLUMNS) + 1) + '|']
    for truth in sorted(matrix):
        counts = [str(matrix[truth].get(column, '')) for column in COLUMNS]
        lines.append(f'| {truth} | ' + ' | '.join(counts) + ' |')
    return '\n'.join(lines) + '\n'


def main(arguments: list[str] | None = None) -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_answers(parser)
    parser.add_argument('--out', type=Path, required=True)
    given = parser.parse_args(arguments)
    if complaint := seal_complaint(given.labels, given.seal):
        print(complaint, file=sys.stderr)
        return 2
    answers, missing = read_answers(given.verdicts, given.labels)
    rows, matrix = score(answers), confusion(answers)
    by_chance = share('right name', shuffled(answers), lambda a: a.is_right, '', '')
    text = report_text(rows, matrix)
    text += f'\nShuffled labels: {by_chance["hits"]} of {by_chance["count"]} names right.\n'
    given.out.mkdir(parents=True, exist_ok=True)
    write_json(
        given.out / 'score.json',
        {
            'metrics': rows,
            'confusion': matrix,
            'failures': failures(answers),
            'missing': missing,
            'shuffled_labels': by_chance,
        },
    )
    (given.out / 'score.md').write_text(text)
    print(text)
    print(f'{len(failures(answers))} failures and {len(missing)} missing, see score.json')
    return 0


if __name__ == '__main__':
    sys.exit(main())
