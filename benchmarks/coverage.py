# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Does the 95 % interval hold the true modulus? Clean synthetic fits; resumes where it stopped.

    python -m benchmarks.coverage --count 1000 --jobs 2 --out DIR

Noise, error of the camera's pose and mesh are as the scene states them; the truth is of other and
smaller elements, and its modulus that of the continuum which sags as it does. Every other fit also
has a rigid offset, drawn from its prior. Fits start near and are those of `diffcal calibrate`, its
search included. Writes
DIR/<body>_<truth>.json and, of all fits that are in DIR, benchmarks/results/coverage.json.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
import json
import math
from pathlib import Path
import sys
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.uncertainty.uncertainty import Z_95
from diffcal_ros.scene.model import DepthSensor
from diffcal_ros.synthetic.lidar import LidarModel
import joblib
import numpy as np
from scipy.stats import binomtest

from benchmarks.measuring import write
from benchmarks.zoo.bodies import BODIES
from benchmarks.zoo.cases import FIT, make_scene, PRIOR, with_start
from benchmarks.zoo.fits import CLAIM, fit
from benchmarks.zoo.stiffening import continuum_modulus
from benchmarks.zoo.truth import draw_truth, Truth
from benchmarks.zoo.views import draw_view, measure, stated_pose

_BODIES = ('beam', 'notched_finger', 'spine', 'plate')
_LEAST_TRUTHS, _MOST_FITS = 10, 10  # Of a body, and of a truth.
_SENSORS = (DepthSensor(0.00014, 0.00025), DepthSensor(0.0003, 0.001))
# Of the camera's pose: shifts [m] and turns [rad].
_POSE_STD = np.array([0.0005] * 3 + [np.deg2rad(0.2)] * 3)
_OFFSET_STD = np.array([PRIOR.translation_std] * 3 + [PRIOR.rotation_std] * 3)
_NEAR = np.log(1.3)
_SEED = 11221963


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--count', type=int, default=1000, help='fits in all')
    parser.add_argument('--jobs', type=int, default=1)
    parser.add_argument('--out', type=Path, required=True)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    each = math.ceil(given.count / len(_BODIES))
    fit_count = min(max(each // _LEAST_TRUTHS, 1), _MOST_FITS)
    truths = [(body, n) for n in range(math.ceil(each / fit_count)) for body in _BODIES]
    files = {one: given.out / f'{one[0]}_{one[1]:03d}.json' for one in truths}
    work = joblib.Parallel(n_jobs=given.jobs, return_as='generator_unordered')
    jobs = [joblib.delayed(_run)(*one, fit_count, file) for one, file in files.items()]
    for told in work(jobs):
        print(told, flush=True)
    fits = [one for file in given.out.glob('*.json') for one in json.loads(file.read_text())]
    rows = {
        name: figures([one for one in fits if name in ('all', one['body'], one['group'])])
        for name in (*_BODIES, 'modulus', 'modulus and offset', 'all')
    }
    write('coverage', rows)
    for name, row in rows.items():
        print(_line(name, row))
    return 0


def figures(fits: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return how many intervals of converged fits hold the truth, and how z is spread.

    z is log(E / E_true) over its standard error, the mesh error taken off E: normal of mean 0 and
    deviation 1 where errors are honest.
    """
    outcomes = [one['outcome'] for one in fits]
    done = [one for one in fits if one['outcome'] == CLAIM]
    z = np.array([one['z'] for one in done])
    row: dict[str, Any] = {
        'n': len(fits),
        'outcomes': {name: outcomes.count(name) for name in sorted(set(outcomes))},
    }
    if not done:
        return row
    held = sum(bool(one['is_covered']) for one in done)
    between = binomtest(held, len(done)).proportion_ci()
    return {
        **row,
        'coverage': held / len(done),
        'coverage_95': [float(between.low), float(between.high)],
        'z_mean': float(z.mean()),
        'z_std': float(z.std(ddof=1)) if len(z) > 1 else float('nan'),
        'relative_std_error': float(np.median([one['std_error'] / one['value'] for one in done])),
        'relative_error': float(np.median([abs(one['error']) for one in done])),
        'fine_error': float(
            np.median([abs(one['fine_value'] / one['youngs_modulus'] - 1.0) for one in done])
        ),
        'median_s': float(np.median([one['seconds'] for one in done])),
    }


def _run(body: str, number: int, fit_count: int, file: Path) -> str:
    """Do the fits of one truth that its file lacks."""
    done = json.loads(file.read_text()) if file.is_file() else []
    if len(done) < fit_count:
        truth = draw_truth(BODIES[body](), _random(body, number))
        for draw in range(len(done), fit_count):
            random = _random(body, number, draw)
            done.append(_fit_one(truth, draw, random, file.parent / 'shapes'))
            write_text_atomically(file, json.dumps(done, indent=1) + '\n')
    return f'{file.stem}: ' + ', '.join(f'{one.get("z", float("nan")):+.2f}' for one in done)


def _fit_one(truth: Truth, draw: int, random: np.random.Generator, shapes: Path) -> dict[str, Any]:
    """Film a truth and fit it from a near start."""
    sensor = _SENSORS[int(random.integers(len(_SENSORS)))]
    lidar = LidarModel(
        sensor.noise, sensor.quantization, edge_noise=0.0, flying_share=0.0, lost_share=0.0
    )
    view = draw_view(truth, (), random)
    has_offset = bool(draw % 2)
    offset = _OFFSET_STD * random.standard_normal(6) if has_offset else np.zeros(6)
    middle = truth.held_middle
    # A model moves what it sees by the pose's error first, then by the offset.
    pose = stated_pose(view.camera_from_world, middle, offset)
    pose = stated_pose(pose, middle, _POSE_STD * random.standard_normal(6))
    seen = Observation('clean', 0, measure(view, lidar, random), view.camera, pose)
    scene = make_scene(truth, sensor, FIT if has_offset else FIT[:1], PRIOR)
    true = continuum_modulus(truth, shapes)
    answer = fit(
        with_start(scene, true * float(np.exp(random.uniform(-_NEAR, _NEAR)))),
        replace(seen, pose_covariance=np.diag(_POSE_STD**2)),
        true,
        None,
    )
    kept = {
        'body': truth.solid.name,
        'group': 'modulus and offset' if has_offset else 'modulus',
        'youngs_modulus': true,
        'of_elements': truth.youngs_modulus,
        'sag': truth.sag,
        **answer,
    }
    if 'value' in answer and answer['std_error'] > 0.0:
        low, high = answer['interval_95']
        error = np.log(high / low) / (2.0 * Z_95)
        kept['z'] = float(np.log(answer['fine_value'] / true) / error)
        kept['is_covered'] = bool(low <= true <= high)
    return kept


def _random(body: str, *numbers: int) -> np.random.Generator:
    return np.random.default_rng([_SEED, _BODIES.index(body), *numbers])


def _line(name: str, row: dict[str, Any]) -> str:
    if 'coverage' not in row:
        return f'{name:18} n {row["n"]:4}  none converged: {row["outcomes"]}'
    low, high = row['coverage_95']
    return (
        f'{name:18} n {row["n"]:4}  covered {row["coverage"]:.1%} ({low:.1%} to {high:.1%})  '
        f'z {row["z_mean"]:+.2f} +- {row["z_std"]:.2f}  error {row["relative_error"]:.2%}, '
        f'stated {row["relative_std_error"]:.2%}  '
        f'{row["median_s"]:.2f} s  {row["outcomes"]}'
    )


if __name__ == '__main__':
    sys.exit(main())
