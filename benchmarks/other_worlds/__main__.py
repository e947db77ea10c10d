# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Judge recordings in other worlds than theirs, each against itself; resumes where it stopped.

    python -m benchmarks.other_worlds --cases DIR/cases --out RUN [--only 'form_*'] [--jobs 2]
                                      [--worlds moved larger] [--fixture]

RUN/<world>/<case>/ hold the recordings, RUN/<world>/<case>/run/verdict.json what is said of them,
RUN/other_worlds.json what they have in common. A world that a case cannot be in is left out.
"""

import argparse
from collections.abc import Sequence
import json
from pathlib import Path
import shutil
import sys
from typing import Any

import joblib

from benchmarks.diagnosis import case_parser, judge
from benchmarks.other_worlds.case_files import read_case, write_case
from benchmarks.other_worlds.comparison import Answer, answer_of, compared
from benchmarks.other_worlds.worlds import AS_IT_IS, NotOfThisWorldError, WORLDS

_VERDICT = Path('run') / 'verdict.json'


def main() -> int:
    """Run the program; return its exit status."""
    given = _arguments()
    cases = sorted({folder for pattern in given.only for folder in given.cases.glob(pattern)})
    if not cases:
        sys.exit(f'no case in {given.cases} is called {" or ".join(given.only)}')
    names = list(dict.fromkeys([AS_IT_IS, *given.worlds]))
    work = joblib.Parallel(n_jobs=given.jobs, return_as='generator_unordered')
    tasks = (
        joblib.delayed(_judged)(case, name, given.out / name / case.name, given.fixture)
        for name in names
        for case in cases
    )
    failures = 0
    for words, is_done in work(tasks):
        failures += not is_done
        print(words, flush=True)
    table = _table(given.out, [case.name for case in cases], names)
    (given.out / 'other_worlds.json').write_text(json.dumps(table, indent=1) + '\n')
    for name, figures in table['worlds'].items():
        print(name, figures)
    return 1 if failures else 0


def _arguments() -> argparse.Namespace:
    parser = case_parser(__doc__.splitlines()[0])
    parser.add_argument(
        '--worlds', nargs='+', choices=list(WORLDS), default=list(WORLDS), help='default: all'
    )
    return parser.parse_args()


def _judged(case: Path, world: str, folder: Path, has_fixture: bool) -> tuple[str, bool]:
    """Put a case into a world and judge it; return words, and whether nothing went wrong."""
    name = f'{world} {case.name}'
    if (folder / _VERDICT).is_file():
        return f'{name} is done', True
    try:
        shutil.rmtree(folder, ignore_errors=True)
        changed = read_case(case)
        WORLDS[world].change(changed)
        write_case(changed, folder)
        words = judge(folder, folder / _VERDICT.parent, has_fixture=has_fixture)
        return f'{name} {words}', True
    except NotOfThisWorldError as error:
        return f'{name} left out: {error}', True
    except Exception as error:  # One bad case must not end the others.
        return f'{name} FAILED: {type(error).__name__}: {error}', False


def _table(out: Path, cases: Sequence[str], worlds: Sequence[str]) -> dict[str, Any]:
    """Return every answer, and how many of each world are as they are."""
    rows: list[dict[str, Any]] = []
    figures: dict[str, dict[str, int]] = {}
    as_they_are = {case: _answer(out / AS_IT_IS / case) for case in cases}
    for world in worlds:
        held = []
        for case, here in as_they_are.items():
            there = _answer(out / world / case)
            if there is None or here is None:
                continue
            same = compared(here, there, WORLDS[world].modulus)
            held.append(same)
            rows.append({'case': case, 'world': world, **there.as_dict(), **same})
        counted = ('is_same', 'contradicts', 'lost_name', 'same_modulus')
        figures[world] = {'cases': len(held)}
        figures[world].update({name: sum(row[name] for row in held) for name in counted})
    return {'worlds': figures, 'cases': rows}


def _answer(folder: Path) -> Answer | None:
    path = folder / _VERDICT
    return answer_of(json.loads(path.read_text())) if path.is_file() else None


if __name__ == '__main__':
    sys.exit(main())
