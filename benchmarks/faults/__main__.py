# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Try the package as an unlucky user would, thousands of times, and count what comes of it.

    python -m benchmarks.faults [--each 21] [--content 400] [--scenes 600] [--environments 164]
                                [--signals 24] [--seed 20] [--no-record]

Bags of twelve layouts are damaged in eight ways (`--each` of each) and read strictly and with what
--allow-truncated does; messages in sound bags, scenes, machines and signals follow. Prints every
fault and a table, writes benchmarks/results/faults.json, and exits with 1 when there was a fault.
"""

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
import sys
import tempfile
from typing import Any

from benchmarks.faults import cases
from benchmarks.faults.cases import CASES_EACH, draw_cases, run_case, SEED
from benchmarks.faults.content import content_cases
from benchmarks.faults.environments import environment_cases
from benchmarks.faults.oracle import FAULTS
from benchmarks.faults.outcome import Outcome
from benchmarks.faults.scenes import scene_cases
from benchmarks.faults.signals import signal_cases
from benchmarks.faults.small_scene import make_small_scene
from benchmarks.measuring import write


def main() -> int:
    """Run the program; return its exit status."""
    given = _arguments()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        bags = _read_bags(given.seed, given.each, folder)
        others = _try_others(given, folder)
    faults = [
        ['bag', one.case.name, one.verdict.outcome, one.verdict.detail]
        for one in bags
        if one.verdict.outcome in FAULTS
    ]
    faults += [
        [one.kind, one.name, one.outcome, one.detail] for one in others if one.outcome in FAULTS
    ]
    for fault in faults:
        print(*fault)
    rows = _rows(bags)
    for row in rows:
        print('  '.join(f'{value}' for value in row.values()))
    counts = {'bag': dict(Counter(one.verdict.outcome for one in bags))}
    for kind in dict.fromkeys(one.kind for one in others):
        counts[kind] = dict(Counter(one.outcome for one in others if one.kind == kind))
    total = len(bags) // 2 + len(others)
    print(f'{total} cases, {len(faults)} faults: {counts}')
    if not given.no_record:
        _record(given.seed, total, counts, faults, rows)
    return 1 if faults else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--each', type=int, default=CASES_EACH, help='of each layout and damage')
    parser.add_argument('--content', type=int, default=400, help='bags with odd messages')
    parser.add_argument('--scenes', type=int, default=600, help='damaged scenes')
    parser.add_argument('--environments', type=int, default=164, help='odd machines')
    parser.add_argument('--signals', type=int, default=24, help='signals')
    parser.add_argument('--seed', type=int, default=SEED)
    parser.add_argument('--no-record', action='store_true', help='write no results')
    return parser.parse_args()


def _read_bags(seed: int, each: int, folder: Path) -> list[cases.Outcome]:
    return [one for case in draw_cases(seed, each) for one in run_case(case, folder)]


def _try_others(given: argparse.Namespace, folder: Path) -> list[Outcome]:
    found = []
    for outcome in _others(given, folder):
        found.append(outcome)
        if outcome.outcome in FAULTS:
            print(outcome, flush=True)
        if len(found) % 50 == 0:
            print(f'{len(found)} others tried', flush=True)
    return found


def _others(given: argparse.Namespace, folder: Path) -> Iterator[Outcome]:
    for name in ('content', 'scenes', 'machines', 'signals'):
        (folder / name).mkdir()
    yield from content_cases(cases.sample(), folder / 'content', given.content, seed=given.seed)
    yield from scene_cases(folder / 'scenes', given.scenes, given.seed)
    if given.environments or given.signals:
        scene = make_small_scene(folder / 'small')
        yield from environment_cases(scene, folder / 'machines', given.environments, given.seed)
        yield from signal_cases(scene, folder / 'signals', given.signals, given.seed)


def _record(
    seed: int, total: int, counts: dict[str, Any], faults: list[Any], rows: list[Any]
) -> None:
    figures = {'seed': seed, 'cases': total, 'outcomes': counts, 'faults': faults}
    write('faults', {**figures, 'layouts': rows})


def _rows(outcomes: list[cases.Outcome]) -> list[dict[str, object]]:
    """Count by layout and way of reading."""
    groups: dict[tuple[str, bool], list[cases.Outcome]] = {}
    for one in outcomes:
        groups.setdefault((one.case.layout.name, one.is_tolerant), []).append(one)
    rows = []
    for (layout, is_tolerant), ones in groups.items():
        intact = sum(one.verdict.intact for one in ones)
        saved = sum(one.verdict.saved for one in ones)
        rows.append(
            {
                'layout': layout,
                'allow_truncated': is_tolerant,
                **Counter(one.verdict.outcome for one in ones),
                'intact_images': intact,
                'saved_images': saved,
            }
        )
    return rows


if __name__ == '__main__':
    sys.exit(main())
