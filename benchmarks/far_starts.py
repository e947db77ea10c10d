# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Calibrate the public captures from random starts, and from the marker's mirrored pose.

    python -m benchmarks.far_starts --data DATASET --out DIR [--count 40] [--only 'h_e*']

DATASET is a clone of the data set, or what the archive unpacks to. Young's modulus starts between
10 kPa and 3 MPa, log-uniform and for each region alone; the offset from a draw of 20 mm and 8
degrees (standard deviations over the three axes together). Resumes where it stopped: one file a
fit in DIR. Writes benchmarks/results/far_starts.json.
"""

import argparse
from dataclasses import replace
from fnmatch import fnmatch
import json
from pathlib import Path
import sys
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import InputError
from diffcal_ros.offline.calibrate_recordings import OfflineInputs, open_inputs
from diffcal_ros.pose.planar_pose import pose_candidates
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.scene.load import load_scene
import joblib
import numpy as np
from numpy.typing import NDArray

from benchmarks.measuring import machine, RESULTS, write

FloatArray = NDArray[np.float64]

CASES = ('h_e_c', 'h_e_s', 'h_em_c', 't_em_c')
_LOWEST, _HIGHEST = 10e3, 3e6  # [Pa]
_SHIFT, _TURN = 0.020, np.deg2rad(8.0)
_SAME = 0.01


def main() -> int:
    """Run the program; return its exit status."""
    given = _arguments()
    chosen = [case for case in CASES if fnmatch(case, given.only)]
    for case in chosen:
        if not (given.out / 'cases' / case / 'scene.yaml').is_file():
            import_case(given.data, case, given.out / 'cases' / case)
    wanted = [(case, number) for number in range(given.count) for case in chosen]
    wanted += [(case, -1) for case in chosen]
    left = [one for one in wanted if not _file(given.out, *one).is_file()]
    work = joblib.Parallel(n_jobs=given.jobs, return_as='generator_unordered')
    for told in work(joblib.delayed(_run)(given.out, *one) for one in left):
        print(told, flush=True)
    fits = [json.loads(_file(given.out, *one).read_text()) for one in wanted]
    summary = [_summary([own for own in fits if own['case'] == case]) for case in chosen]
    write('far_starts', _with_earlier(summary, fits))
    print(json.dumps(summary, indent=1))
    return 0


def _with_earlier(summary: list[dict[str, Any]], fits: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the figures, those of cases that were not run this time as they were."""
    commit = machine()['commit']
    done = {case['case']: {**case, 'commit': commit} for case in summary}
    path = RESULTS / 'far_starts.json'
    earlier = json.loads(path.read_text())['figures'] if path.is_file() else {}
    kept = {case['case']: case for case in earlier.get('cases', ())}
    left = [fit for fit in earlier.get('fits', ()) if fit['case'] not in done]
    return {'cases': list((kept | done).values()), 'fits': [*left, *fits]}


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--data', type=Path, required=True)
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--count', type=int, default=40)
    parser.add_argument('--only', default='*')
    parser.add_argument('--jobs', type=int, default=1)
    return parser.parse_args()


def _file(out: Path, case: str, number: int) -> Path:
    return out / 'fits' / f'{case}_{"mirrored" if number < 0 else f"{number:02d}"}.json'


def _run(out: Path, case: str, number: int) -> str:
    folder = out / 'cases' / case
    inputs = open_inputs(load_scene(folder / 'scene.yaml'), [folder / 'bag'])
    kept = {'case': case, 'number': number, **_fit(inputs, number)}
    write_text_atomically(_file(out, case, number), json.dumps(kept, indent=1) + '\n')
    return f'{case} {number}: {kept["outcome"]} {kept.get("moduli")} in {kept.get("seconds")} s'


def _fit(inputs: OfflineInputs, number: int) -> dict[str, Any]:
    observations = inputs.observations
    if number < 0:
        observations = tuple(
            replace(seen, depth_from_world=_mirrored(inputs, seen.depth_from_world, seen.camera))
            for seen in observations
        )
    try:
        calibration = Calibration(
            inputs.scene, observations, CalibrationSettings(with_mesh_error=False)
        )
        if number >= 0:
            calibration.go_to(_start(calibration, np.random.default_rng([17, number])))
        begun = calibration.parameters.values(calibration.coordinates)
        result = calibration.run()
    except InputError as error:
        return {'outcome': 'input_error', 'reason': str(error)}
    gap = result.gap_end
    return {
        'outcome': result.outcome.value,
        # What the fit adds to its model had no start.
        'start': {name: begun[name] for name in result.values() if name in begun},
        'moduli': _moduli(result.values()),
        'values': result.values(),
        'gap': gap.as_dict(),
        'alternatives': [
            {'moduli': _moduli(own.values), 'misfit_above': own.misfit, 'as_good': own.is_as_good}
            for own in result.alternatives
        ],
        'iterations': result.iterations,
        'seconds': round(result.seconds, 2),
    }


def _moduli(values: dict[str, float]) -> dict[str, float]:
    return {name: value for name, value in values.items() if name.startswith('youngs_modulus')}


def _start(calibration: Calibration, random: np.random.Generator) -> FloatArray:
    start = calibration.coordinates.copy()
    for place, own in enumerate(calibration.parameters):
        if own.kind is Kind.YOUNGS_MODULUS:
            start[place] = random.uniform(np.log(_LOWEST), np.log(_HIGHEST))
        elif own.kind is Kind.RIGID_OFFSET:
            start[place] = random.normal() * (_SHIFT if own.axis < 3 else _TURN) / np.sqrt(3.0)
    return np.clip(start, *calibration.parameters.bounds())


def _mirrored(
    inputs: OfflineInputs, depth_from_world: FloatArray, camera: PinholeCamera
) -> FloatArray:
    """Return the other pose under which the marker's corners look about as they do."""
    marker = inputs.scene.marker
    assert marker is not None
    half = 0.5 * marker.side
    corners = np.array([[-half, half, 0], [half, half, 0], [half, -half, 0], [-half, -half, 0]])
    (recording,) = inputs.recordings
    color_camera, depth_from_color = recording.color_camera, recording.depth_from_color
    assert color_camera is not None
    assert depth_from_color is not None
    color_from_marker = inverse(depth_from_color) @ depth_from_world @ marker.world_from_marker
    ideal = replace(color_camera, distortion=())
    pixels = ideal.project(apply(color_from_marker, corners))
    found = pose_candidates(corners, pixels, ideal)
    other = max(found, key=lambda own: np.abs(own.camera_from_marker - color_from_marker).max())
    return depth_from_color @ other.camera_from_marker @ inverse(marker.world_from_marker)


def _summary(fits: list[dict[str, Any]]) -> dict[str, Any]:
    starts = [own for own in fits if own['number'] >= 0]
    (mirrored,) = [own for own in fits if own['number'] < 0]
    ended = [own for own in starts if 'moduli' in own]
    names = list(ended[0]['moduli']) if ended else []
    middle = {name: float(np.median([own['moduli'][name] for own in ended])) for name in names}
    near = [
        all(abs(own['moduli'][name] / middle[name] - 1.0) <= _SAME for name in names)
        for own in ended
    ]
    return {
        'case': starts[0]['case'],
        'starts': len(starts),
        'moduli': middle,
        'within_1_percent_of_the_median': sum(near),
        'converged_elsewhere': sum(
            own['outcome'] == 'converged' and not is_near
            for own, is_near in zip(ended, near, strict=True)
        ),
        'spread': {
            name: float(np.ptp([own['moduli'][name] for own in ended]) / middle[name])
            for name in names
        },
        'outcomes': {
            outcome: sum(own['outcome'] == outcome for own in starts)
            for outcome in sorted({own['outcome'] for own in starts})
        },
        'gap': ended[0]['gap'] if ended else None,
        'seconds_median': float(np.median([own['seconds'] for own in ended])) if ended else None,
        'mirrored_pose': {
            key: mirrored.get(key) for key in ('outcome', 'reason', 'moduli', 'gap')
        },
    }


if __name__ == '__main__':
    sys.exit(main())
