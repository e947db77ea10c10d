# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal batch`: many recordings, one table and one page."""

import argparse
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from io import StringIO
import time
from typing import Any, TYPE_CHECKING

from diffcal_ros.cli.heartbeat import Heartbeat
from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.say import say

if TYPE_CHECKING:
    from collections.abc import Sequence

    from diffcal_ros.batch.body_result import BodyResult
    from diffcal_ros.batch.job import Account, Job
    from diffcal_ros.batch.manifest import Body
    from diffcal_ros.workers.ended import Workers

# What a batch exits with: the gravest that became of a body, the first of these.
_GRAVEST = (2, 3, 4, 5)
_BAD_INPUT = 2


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'batch',
        help='calibrate or diagnose many recordings, on one machine or many',
        description='Calibrate, or diagnose, every body of MANIFEST, and write a folder for each '
        'to DIR/bodies, and DIR/batch.html, batch.csv and batch.json of all: moduli, outliers, '
        'which bodies share a material, and one fit of each material with an offset of every '
        'body. What is done already is not done again; what was killed goes on.',
        epilog='Exit codes: 0 every body converged or has a verdict; else the gravest of them: '
        '2 something could not be done; 3, 4 and 5 as of `diffcal calibrate`, see also `diffcal '
        '--help`.',
    )
    parser.add_argument(
        'manifest',
        metavar='MANIFEST',
        type=path_argument,
        help='bodies, their scenes, recordings, materials and options, in YAML or CSV',
    )
    parser.add_argument(
        '--out',
        metavar='DIR',
        type=path_argument,
        required=True,
        help='folder of results; run it again to go on',
    )
    parser.add_argument(
        '--cluster',
        metavar='ADDRESS',
        help='of a Dask scheduler, such as tcp://head:8786, whose workers see the same folders '
        '(default: processes of this machine)',
    )
    parser.add_argument(
        '--jobs', metavar='N', type=int, help='processes of this machine (default: one a core)'
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Do the batch and write what is found; return the exit code."""
    from diffcal_ros.batch.manifest import load_manifest
    from diffcal_ros.batch.run import plan, run_batch
    from diffcal_ros.batch.summary import summarise, write_summary
    from diffcal_ros.report.pages.batch_page import write_batch_page
    from diffcal_ros.report.tables.batch_text import batch_lines

    workers = _workers(args)
    bodies = load_manifest(args.manifest, _fault_in_options)
    jobs = plan(bodies, args.out)
    over: list[BodyResult] = []
    args.what_is_left = lambda: (
        f'interrupted; {len(over)} were done in this run, and what is done is kept in {args.out}: '
        'run it again to go on'
    )
    begun = time.monotonic()
    with Heartbeat('at work on the bodies'):

        def on_ended(number: int, count: int, result: 'BodyResult') -> None:
            over.append(result)
            say(f'[{time.monotonic() - begun:5.0f} s] {number} of {count}: {_in_words(result)}')

        results = run_batch(bodies, jobs, do_job_of_batch, workers, on_ended)
    summary = summarise(results)
    write_summary(summary, args.out)
    write_batch_page(args.out, args.manifest.stem, summary)
    print('\n'.join(batch_lines(summary, args.out, len(over))))
    return _exit_code(results)


def _workers(args: argparse.Namespace) -> 'Workers':
    from diffcal_ros.calibration.forward.side_by_side import core_count
    from diffcal_ros.errors import InputError
    from diffcal_ros.workers.dask_cluster import DaskCluster
    from diffcal_ros.workers.local_processes import LocalProcesses

    if args.cluster is not None:
        if args.jobs is not None:
            raise InputError(
                '--jobs are processes of this machine, and --cluster has workers of its own: '
                'leave one of them out'
            )
        return DaskCluster(args.cluster, tell=say)
    jobs = core_count() if args.jobs is None else args.jobs
    if jobs < 1:
        raise InputError(f'--jobs is {jobs}: give how many processes may work at once')
    return LocalProcesses(jobs, threads=max(core_count() // jobs, 1))


def do_job_of_batch(job: 'Job') -> 'Account':
    """Do one job, in whichever process this is."""
    from diffcal_ros.batch.job import do_job
    from diffcal_ros.cli.main import main

    return do_job(job, main)


@cache
def _parser() -> argparse.ArgumentParser:
    from diffcal_ros.cli.main import make_parser

    return make_parser()


def _fault_in_options(body: 'Body') -> str:
    """Say what the command itself would say of a body's options; nothing where they are right."""
    command, *rest = body.arguments()
    # Before the options, so that another --out among them shows.
    given = [command, '--out', str(body.scene.parent), *rest]
    said, shown = StringIO(), StringIO()
    try:
        with redirect_stderr(said), redirect_stdout(shown):
            parsed = _parser().parse_args(given)
    except SystemExit:
        fault = said.getvalue().strip().rpartition('error: ')[2] or 'ask for help'
        return f'are {" ".join(body.options)!r}: {fault}'
    if (parsed.scene, parsed.out) != (body.scene, body.scene.parent):
        return f'are {" ".join(body.options)!r}: --scene and --out have keys of their own'
    if parsed.bags != list(body.recordings):
        return f'are {" ".join(body.options)!r}: recordings have a key of their own'
    return ''


def _in_words(result: 'BodyResult') -> str:
    from diffcal_ros.report.tables.batch_text import body_words

    return f'{result.body.name}: {body_words(result)}'


def _exit_code(results: 'Sequence[BodyResult]') -> int:
    codes = {_code(result) for result in results}
    return next((code for code in _GRAVEST if code in codes), 0)


def _code(result: 'BodyResult') -> int:
    if result.account is None or not result.account.is_done or not result.content:
        return _BAD_INPUT
    return result.account.exit_code
