# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit the zoo from far starts; resumes where it stopped.

    python -m benchmarks.zoo --out DIR [--only 'spine*'] [--views 15] [--jobs 1] [--pictures]

Writes DIR/cases/<body>_<number>.json, with --pictures DIR/pictures/<body>_<number>.png, and
benchmarks/results/zoo.json of all cases that are in DIR.
"""

import argparse
from fnmatch import fnmatch
import json
from pathlib import Path
import sys

from diffcal_ros.atomic_file import write_text_atomically
import joblib

from benchmarks.measuring import write
from benchmarks.zoo.bodies import BODIES
from benchmarks.zoo.cases import draw_case
from benchmarks.zoo.fits import run_case
from benchmarks.zoo.pictures import draw_picture
from benchmarks.zoo.summary import summarise, table


def main() -> int:
    """Run the program; return its exit status."""
    given = _arguments()
    folder = given.out / 'cases'
    folder.mkdir(parents=True, exist_ok=True)
    # Body by body in turn: a study that is stopped has some of each.
    wanted = [(body, number) for number in range(given.views) for body in BODIES]
    chosen = [one for one in wanted if fnmatch(_name(*one), given.only)]
    left = [one for one in chosen if not (folder / f'{_name(*one)}.json').is_file()]
    print(f'{len(chosen) - len(left)} of {len(chosen)} cases are done')
    work = joblib.Parallel(n_jobs=given.jobs, return_as='generator_unordered')
    for told in work(joblib.delayed(_run)(*one, given.out, given.pictures) for one in left):
        print(told, flush=True)
    cases = [json.loads(file.read_text()) for file in sorted(folder.glob('*.json'))]
    if not cases:
        print(f'no case is called {given.only}: bodies are {", ".join(BODIES)}', file=sys.stderr)
        return 2
    rows = summarise(cases)
    write('zoo', {'bodies': rows, 'cases': cases})
    print(table(rows))
    return 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--only', default='*', help='pattern of case names')
    parser.add_argument('--views', type=int, default=15, help='cases of each body')
    parser.add_argument('--jobs', type=int, default=1)
    parser.add_argument('--pictures', action='store_true')
    return parser.parse_args()


def _name(body: str, number: int) -> str:
    return f'{body}_{number:02d}'


def _run(body: str, number: int, out: Path, with_picture: bool) -> str:
    case = draw_case(body, number)
    if with_picture:
        draw_picture(case, out / 'pictures' / f'{case.name}.png')
    kept = run_case(case)
    write_text_atomically(out / 'cases' / f'{case.name}.json', json.dumps(kept, indent=1) + '\n')
    far, near = kept['far'], kept['near']
    return (
        f'{case.name:18} {kept["verdict"]:8} {far["outcome"]:16} '
        f'{far.get("error", float("nan")):+8.1%} in {far["seconds"]:5.1f} s; from the truth '
        f'{near["outcome"]:16} {near.get("error", float("nan")):+7.1%}'
    )


if __name__ == '__main__':
    sys.exit(main())
