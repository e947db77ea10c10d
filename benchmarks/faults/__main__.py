# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read the sample's bag in twelve layouts, damaged in eight ways, and count what comes of it.

    python -m benchmarks.faults [--each 11] [--seed 20]

Each damaged file is read strictly and with what --allow-truncated does. Prints a table and every
fault, writes benchmarks/results/faults.json, and exits with 1 when there was a fault.
"""

import argparse
from collections import Counter
from pathlib import Path
import sys
import tempfile

from benchmarks.faults.cases import CASES_EACH, draw_cases, Outcome, run_case, SEED
from benchmarks.faults.oracle import FAULTS
from benchmarks.measuring import write


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--each', type=int, default=CASES_EACH, help='of each layout and damage')
    parser.add_argument('--seed', type=int, default=SEED)
    given = parser.parse_args()
    outcomes: list[Outcome] = []
    with tempfile.TemporaryDirectory() as folder:
        for case in draw_cases(given.seed, given.each):
            outcomes += run_case(case, Path(folder))
    faults = [one for one in outcomes if one.verdict.outcome in FAULTS]
    for one in faults:
        print(f'{one.case.name}: {one.verdict.outcome} {one.verdict.detail}')
    rows = _rows(outcomes)
    for row in rows:
        print('  '.join(f'{value}' for value in row.values()))
    total = Counter(one.verdict.outcome for one in outcomes)
    print(dict(total))
    write(
        'faults',
        {
            'seed': given.seed,
            'files': len(outcomes) // 2,
            'outcomes': dict(total),
            'slowest_s': round(max(one.verdict.seconds for one in outcomes), 2),
            'faults': [[one.case.name, one.verdict.outcome, one.verdict.detail] for one in faults],
            'layouts': rows,
        },
    )
    return 1 if faults else 0


def _rows(outcomes: list[Outcome]) -> list[dict[str, object]]:
    """Count by layout and way of reading."""
    groups: dict[tuple[str, bool], list[Outcome]] = {}
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
