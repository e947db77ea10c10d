# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run the diagnosis on blind cases; resumes where it stopped.

    python -m benchmarks.diagnosis --cases DIR/cases --out RUN [--only 'case_*'] [--jobs 2]
                                   [--processes 1] [--fixture] [--cluster tcp://HOST:8786]

It sees the cases, never the generator or the labels; `python -m benchmarks.blind.scorer` reads
both. RUN/<case>/verdict.json are the verdicts. A cluster is the address of a Dask scheduler whose
workers see the same folders; otherwise all cores of this machine work.
"""

import argparse
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
import os
from pathlib import Path
import sys
import time
from typing import Any, TYPE_CHECKING

import joblib
import numpy as np
import yaml

if TYPE_CHECKING:
    from diffcal_ros.scene.model import Fixture


def main() -> int:
    """Run the program; return its exit status."""
    given = _arguments()
    folders = [f for pattern in given.only for f in sorted(given.cases.glob(pattern))]
    left = [f for f in folders if not (given.out / f.name / 'verdict.json').is_file()]
    print(f'{len(folders) - len(left)} of {len(folders)} cases are done')
    begun, failures = time.perf_counter(), 0
    with _workers(given.cluster):
        work = joblib.Parallel(n_jobs=given.jobs, return_as='generator_unordered')
        verdicts = work(
            joblib.delayed(_judge_safely)(f, given.out / f.name, given.fixture, given.processes)
            for f in left
        )
        for number, (name, words, is_done) in enumerate(verdicts, start=1):
            failures += not is_done
            seconds = time.perf_counter() - begun
            print(f'{number}/{len(left)} {name} {words}, {seconds:.0f} s', flush=True)
    if failures:
        print(f'{failures} cases failed; the same command tries them again', file=sys.stderr)
    return 1 if failures else 0


def _arguments() -> argparse.Namespace:
    parser = case_parser(__doc__.splitlines()[0])
    parser.add_argument(
        '--processes', type=int, default=1, help='that refit the models of one case (1)'
    )
    parser.add_argument('--cluster', help='address of a Dask scheduler')
    return parser.parse_args()


def case_parser(description: str) -> argparse.ArgumentParser:
    """Return a parser of which cases to judge, where to, and how."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument('--cases', type=Path, required=True)
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--only', nargs='+', default=['*'], help='patterns of case names')
    parser.add_argument('--jobs', type=int, default=os.cpu_count(), help='default: all cores')
    parser.add_argument(
        '--fixture', action='store_true', help='state the block around the clamp in every scene'
    )
    return parser


@contextmanager
def _workers(cluster: str | None) -> Iterator[None]:
    """Let joblib use a cluster's workers, or this machine's."""
    if cluster is None:
        yield
        return
    try:
        from distributed import Client
    except ImportError:
        sys.exit('--cluster needs Dask: pip install distributed')
    with Client(cluster), joblib.parallel_config('dask'):
        yield


def _judge_safely(
    case: Path, out: Path, has_fixture: bool, processes: int
) -> tuple[str, str, bool]:
    """Judge a case; return its name, the verdict or the error, and whether there is a verdict."""
    try:
        words = judge(case, out, has_fixture=has_fixture, processes=processes)
        return case.name, words, True
    except Exception as error:  # One bad case must not end the others.
        return case.name, f'FAILED: {type(error).__name__}: {error}', False


def judge(case: Path, out: Path, *, has_fixture: bool = False, processes: int = 1) -> str:
    """Diagnose one case as a user would; return the verdict in a few words.

    Args:
        case: its folder.
        out: where the verdict goes.
        has_fixture: the scene states the block around the clamp.
        processes: that refit models, as `--jobs` of `diffcal diagnose`.
    """
    from diffcal_ros.diagnosis.settings import DiagnosisSettings
    from diffcal_ros.offline.calibrate_recordings import open_inputs
    from diffcal_ros.offline.diagnose_recordings import run_diagnosis
    from diffcal_ros.scene.load import load_scene

    extra = yaml.safe_load((case / 'extra.yaml').read_text())
    ruled_out = extra.get('library_without')
    without = (ruled_out,) if ruled_out else ()
    settings = DiagnosisSettings(without=without, jobs=processes)
    scene = load_scene(case / 'scene.yaml')
    if has_fixture:
        scene = replace(scene, fixture=clamp_fixture(extra['fixture']))
    inputs = open_inputs(scene, [], pose_source='stored')
    diagnosis = run_diagnosis(inputs, settings, out).diagnosis
    named = ', '.join(effect.identifier for effect in diagnosis.effects)
    return f'{diagnosis.verdict.value} {named or diagnosis.unknown_class or ""}'.strip()


def clamp_fixture(stated: Mapping[str, Any]) -> 'Fixture':
    """Return the block around a clamp, or those around several as one surface.

    Args:
        stated: `box`, or `boxes`, each with the limits of x, y and z, object frame [m].
    """
    from diffcal_ros.scene.sections.fixture import blocks_fixture

    boxes = stated.get('boxes') or [stated['box']]
    return blocks_fixture([np.array([box[axis] for axis in 'xyz']).T for box in boxes])


if __name__ == '__main__':
    sys.exit(main())
