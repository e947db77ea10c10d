# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Batches: killed at random, their overhead, and how they scale; resumes where it stopped.

    python -m benchmarks.batch kills --out DIR [--count 200] [--jobs 4] [--alone 10]
    python -m benchmarks.batch overhead [--tasks 60]     # needs Dask: '.[cluster]'
    python -m benchmarks.batch scaling --out DIR         # the same; after kills

Writes benchmarks/results/batch_kills.json, batch_overhead.json and batch_scaling.json. Times are
those of processors or of sleeping tasks: neither minds what else the machine does.
"""

import argparse
import json
from pathlib import Path
import sys
from typing import Any

from diffcal_ros.batch.job import MARK
from diffcal_ros.batch.run import FOLDER
import numpy as np

from benchmarks.batch.kills import one_by_one, run_killed, same_figures, workers_of
from benchmarks.batch.recordings import make_recordings, TRUTH
from benchmarks.batch.scaling import overhead, scaling
from benchmarks.measuring import write

# A worker, or in three of ten cases the master, is killed after so many more bodies.
_BETWEEN = (10, 30)
_SEED = 21


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('what', choices=('kills', 'overhead', 'scaling'))
    parser.add_argument('--out', type=Path)
    parser.add_argument('--count', type=int, default=200, help='recordings')
    parser.add_argument('--jobs', type=int, default=4, help='workers of the batch')
    parser.add_argument('--alone', type=int, default=10, help='bodies done one by one as well')
    parser.add_argument('--tasks', type=int, default=60, help='sleeping tasks of the overhead')
    given = parser.parse_args()
    if given.what == 'overhead':
        write('batch_overhead', overhead(given.tasks))
    elif given.out is None:
        parser.error('give the folder of the recordings with --out')
    elif given.what == 'scaling':
        write('batch_scaling', scaling(_task_seconds(given.out / 'batch')))
    else:
        return _kills(given)
    return 0


def _kills(given: argparse.Namespace) -> int:
    """Do a batch under random kills; return 1 where anything was lost, done twice or different."""
    made, out = given.out / 'recordings', given.out / 'batch'
    manifest = make_recordings(made, given.count, _SEED)
    command = ['batch', str(manifest), '--out', str(out), '--jobs', str(given.jobs)]
    kills = run_killed(command, out, between=_BETWEEN, seed=_SEED, workers_of=workers_of)
    accounts = _accounts(out)
    step = max(given.count // max(given.alone, 1), 1)
    chosen = [accounts[name] for name in sorted(accounts)[::step]]
    alone = one_by_one([account['arguments'] for account in chosen], given.out / 'alone')
    same = [
        same_figures(out / FOLDER / account['name'] / 'result.json', result)
        for account, result in zip(chosen, alone, strict=True)
    ]
    left = [path.name for path in (out / FOLDER).glob('.*') if path.name != '.locks']
    figures = {
        'recordings': given.count,
        'jobs': given.jobs,
        'workers_killed': kills.workers,
        'masters_killed': kills.masters,
        'runs': kills.runs,
        'done': sum(account['exit_code'] in (0, 3, 4, 5) for account in accounts.values()),
        'lost': given.count - len(accounts),
        'results_written_again': kills.changed,
        'left_half_done': len(left),
        'done_alone': len(same),
        'same_to_the_last_digit': sum(same),
        'processor_s_a_body': float(
            np.median([account['processor_seconds'] for account in accounts.values()])
        ),
        'found': _found(out, json.loads((made / TRUTH).read_text())),
    }
    write('batch_kills', figures)
    is_right = not (figures['lost'] or kills.changed or left) and all(same)
    return 0 if is_right and figures['done'] == given.count else 1


def _accounts(out: Path) -> dict[str, dict[str, Any]]:
    marks = (out / FOLDER).glob(f'[!.]*/{MARK}')
    return {mark.parent.name: json.loads(mark.read_text()) for mark in marks}


def _task_seconds(out: Path) -> list[float]:
    """Return how long the processor had to work for each body [s]."""
    return [own['processor_seconds'] for _, own in sorted(_accounts(out).items())]


def _found(out: Path, truth: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    """Return what the batch says of each material, beside what is true of its bodies."""
    table = []
    for fit in json.loads((out / 'batch.json').read_text())['materials']:
        own = {n: one for n, one in truth.items() if one['material'] == fit['material']}
        mixed_up = {name for name, one in own.items() if one['is_mixed_up']}
        logs = np.log([one['modulus'] for n, one in own.items() if n in set(fit['bodies'])])
        named = set(fit['outliers'])
        table.append(
            {
                'material': fit['material'],
                'bodies': len(fit['bodies']),
                'mean': fit['mean'],
                'interval_95': fit['interval_95'],
                'true_median': float(np.exp(np.median(logs))),
                'spread_share': fit['spread'] / fit['mean'],
                'spread_share_95': [end / fit['mean'] for end in fit['spread_95']],
                'mixed_up': len(mixed_up & set(fit['bodies'])),
                'mixed_up_named': len(mixed_up & named),
                'named_wrongly': len(named - mixed_up),
            }
        )
    return table


if __name__ == '__main__':
    sys.exit(main())
