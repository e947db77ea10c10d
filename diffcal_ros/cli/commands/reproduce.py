# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal reproduce`: the paper's experiments, ours beside the paper's figures."""

import argparse
from collections.abc import Iterator
import os
from pathlib import Path
import sys
import time
from typing import Any, TYPE_CHECKING

from diffcal_ros.cli.lasting_stream import lasting_streams
from diffcal_ros.cli.options.path_argument import path_argument

if TYPE_CHECKING:
    from diffcal_ros.calibration.calibrate import Calibration
    from diffcal_ros.calibration.results.result import CalibrationResult
    from diffcal_ros.reproduction.row import Row

_ALL = 'all'
_PAGE, _TABLE = 'reproduce.html', 'reproduce.json'
_DATASET = 'DIFFCAL_DATA'
_EXIT_BAD_INPUT = 2


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'reproduce',
        help="do the paper's experiments and set ours beside the paper's figures",
        description='Do experiments of the paper, each from random starts, and write one page, '
        f'DIR/{_PAGE}, and DIR/{_TABLE}. What is done already is not done again. Without '
        'arguments, lists the experiments.',
    )
    parser.add_argument(
        'rows',
        metavar='ROW',
        nargs='*',
        help='experiments by name, YAML files of your own, or all',
    )
    parser.add_argument('--list', action='store_true', help='list the experiments')
    parser.add_argument(
        '--data',
        metavar='PATH',
        type=path_argument,
        help=f'root of a clone of the public DiffCal data set (default: ${_DATASET})',
    )
    parser.add_argument(
        '--starts', metavar='N', type=int, default=10, help='random starts (default: 10)'
    )
    parser.add_argument(
        '--out', metavar='DIR', type=path_argument, help='folder of results; run it again to go on'
    )
    parser.add_argument(
        '--jobs',
        metavar='N',
        type=int,
        default=2,
        help='experiments done side by side, each in a process of its own (default: 2)',
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Do what was asked for and write the page; return the exit code."""
    from diffcal_ros.errors import InputError
    from diffcal_ros.reproduction.row import load_row, row_names

    if args.list or not args.rows:
        rows = [load_row(name) for name in row_names()]
        width = max(len(row.name) for row in rows)
        print('\n'.join(f'{row.name:<{width}}  {row.title}' for row in rows))
        return 0
    if args.out is None:
        raise InputError('where are the results to go? Give a folder with --out')
    if args.starts < 1:
        raise InputError(f'{args.starts} starts were asked for: give at least 1')
    if args.jobs < 1:
        raise InputError(f'{args.jobs} jobs were asked for: give at least 1')
    names = row_names() if _ALL in args.rows else args.rows
    rows = [load_row(name) for name in names]
    return _run_rows(rows, _dataset(args.data), args)


def _dataset(given: Path | None) -> Path | None:
    """Return the data set's root, where one was given."""
    from diffcal_ros.errors import InputError

    stated = os.environ.get(_DATASET)
    folder = given or (Path(stated) if stated else None)
    if folder is not None and not (folder / 'exp_data').is_dir():
        raise InputError(
            f'{folder} holds no exp_data folder: give the root of a clone of the DiffCal data set '
            f'with --data, or in ${_DATASET}'
        )
    return folder


def _run_rows(rows: list['Row'], dataset: Path | None, args: argparse.Namespace) -> int:
    """Do the rows; the page is whole after each."""
    refused = 0
    for row, error in _done(rows, dataset, args):
        if error:
            # One experiment without its data must not cost the others.
            print(f'diffcal reproduce: {row.name}: {error}', file=sys.stderr)
            refused += 1
        _write(rows, args.out, args.starts)
    print(f'page   {args.out / _PAGE}\ntable  {args.out / _TABLE}')
    return _EXIT_BAD_INPUT if refused else 0


def _done(
    rows: list['Row'], dataset: Path | None, args: argparse.Namespace
) -> Iterator[tuple['Row', str]]:
    """Do the rows, some side by side; yield each when it is done, with what stopped it."""
    from concurrent.futures import as_completed
    from concurrent.futures.process import BrokenProcessPool

    from diffcal_ros.errors import InputError
    from diffcal_ros.process_pool import process_pool

    begun = time.time()
    jobs = min(args.jobs, len(rows))
    if jobs == 1:
        for row in rows:
            yield row, _run_one(row, dataset, args.out, args.starts, begun)
        return
    with process_pool(jobs) as pool:
        running = {
            pool.submit(_run_one, row, dataset, args.out, args.starts, begun): row for row in rows
        }
        try:
            for future in as_completed(running):
                yield running[future], future.result()
        except BrokenProcessPool as error:
            raise InputError(
                'a process died (was there memory enough?): run it again with --jobs 1; what is '
                f'done is kept in {args.out}'
            ) from error
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise


def _run_one(row: 'Row', dataset: Path | None, out: Path, starts: int, begun: float) -> str:
    """Do one row; return why it could not be done, or nothing."""
    from diffcal_ros.errors import InputError
    from diffcal_ros.reproduction.run_row import run_row

    def report(text: str) -> None:
        print(f'[{time.time() - begun:5.0f} s] {text}', file=sys.stderr, flush=True)

    try:
        with lasting_streams():
            run_row(row, dataset, out, starts=starts, draw=_draw, report=report)
    except InputError as error:
        return str(error)
    return ''


def _draw(path: Path, calibration: 'Calibration', result: 'CalibrationResult') -> None:
    from diffcal_ros.atomic_file import write_bytes_atomically
    from diffcal_ros.report.figures.depth_figure import depth_figure, depth_range
    from diffcal_ros.report.figures.figure_png import png_bytes
    from diffcal_ros.report.figures.observed_view import observed_views

    views = observed_views(calibration, result)
    write_bytes_atomically(path, png_bytes(depth_figure(views[0], depth_range(views))))


def _write(rows: list['Row'], out: Path, starts: int) -> None:
    import json

    from diffcal_ros.atomic_file import write_text_atomically
    from diffcal_ros.report.pages.reproduction_page import write_reproduction_page
    from diffcal_ros.reproduction.summary import summarise

    found = [(row, summarise(row, out, starts)) for row in rows]
    table = {
        'format': 1,
        'rows': {
            row.name: {'title': row.title, 'variants': [item.as_dict() for item in summaries]}
            for row, summaries in found
        },
    }
    write_text_atomically(out / _TABLE, json.dumps(table, indent=2) + '\n')
    write_reproduction_page(out / _PAGE, found)
