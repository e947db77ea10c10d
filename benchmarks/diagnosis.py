# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run the diagnosis on blind cases; resumes where it stopped.

    python -m benchmarks.diagnosis --cases DIR/cases --out RUN [--only 'case_*'] [--jobs 2]

It sees the cases, never the generator or the labels; `python -m benchmarks.blind.scorer` reads
both. RUN/<case>/verdict.json are the verdicts.
"""

import argparse
from concurrent.futures import as_completed, ProcessPoolExecutor
from pathlib import Path
import time

import yaml


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--cases', type=Path, required=True)
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--only', nargs='+', default=['*'], help='patterns of case names')
    parser.add_argument('--jobs', type=int, default=2)
    args = parser.parse_args()
    folders = [f for pattern in args.only for f in sorted(args.cases.glob(pattern))]
    left = [f for f in folders if not (args.out / f.name / 'verdict.json').is_file()]
    print(f'{len(folders) - len(left)} of {len(folders)} cases are done')
    begun = time.perf_counter()
    with ProcessPoolExecutor(args.jobs) as pool:
        running = {pool.submit(judge, f, args.out / f.name): f for f in left}
        for number, done in enumerate(as_completed(running), start=1):
            seconds = time.perf_counter() - begun
            error = done.exception()
            what = done.result() if error is None else f'FAILED: {error}'
            print(f'{number}/{len(left)} {running[done].name} {what}, {seconds:.0f} s', flush=True)


def judge(case: Path, out: Path) -> str:
    """Diagnose one case as a user would; return the verdict in a few words."""
    from diffcal_ros.diagnosis.diagnose import DiagnosisSettings
    from diffcal_ros.offline.calibrate_recordings import open_inputs
    from diffcal_ros.offline.diagnose_recordings import run_diagnosis
    from diffcal_ros.scene.load import load_scene

    extra = yaml.safe_load((case / 'extra.yaml').read_text())
    ruled_out = extra.get('library_without')
    settings = DiagnosisSettings(without=(ruled_out,) if ruled_out else ())
    inputs = open_inputs(load_scene(case / 'scene.yaml'), [], pose_source='stored')
    diagnosis = run_diagnosis(inputs, settings, out).diagnosis
    named = ', '.join(effect.identifier for effect in diagnosis.effects)
    return f'{diagnosis.verdict.value} {named or diagnosis.unknown_class or ""}'.strip()


if __name__ == '__main__':
    main()
