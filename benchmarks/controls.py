# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Controls of the diagnosis: what it says of data in which nothing is hidden, or nothing physical.

    python -m benchmarks.controls --cases DIR/cases [--only 'clean_0[0-2]*'] [--jobs 2]

Four arms on the same clean cases, all fitted alike: the independent data as they are; the same
without the allowance for the mesh; data of this package's own mesh and renderer with white noise;
and those with a smooth error of the sensor on top. On cases whose names begin with `case_`, the
first effect by its score competes with random smooth directions of as many amplitudes. Writes
benchmarks/results/controls.json.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
import sys
from typing import Any

import joblib
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from benchmarks.measuring import write

FloatArray = NDArray[np.float64]

# Of the sensor's smooth error: root mean square [m] and length [px], as the floor expects it.
_SMOOTH, _LENGTH = 0.00012, 40.0
_NOISE, _STEP = 0.00014, 0.00025  # [m]
_DIRECTIONS = 40
_WIGGLES = 2  # Highest power of a random direction along each axis.


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--cases', type=Path, required=True)
    parser.add_argument('--only', nargs='+', default=['clean_0[0-2]*', 'case_0[0-3]*'])
    parser.add_argument('--jobs', type=int, default=2)
    given = parser.parse_args()
    folders = [f for pattern in given.only for f in sorted(given.cases.glob(pattern))]
    work = joblib.Parallel(n_jobs=given.jobs)
    clean = [f for f in folders if f.name.startswith('clean_')]
    arms = work(joblib.delayed(_arms)(folder) for folder in clean)
    faulty = [f for f in folders if f.name.startswith('case_')]
    ranks = [r for r in work(joblib.delayed(_rank)(f) for f in faulty) if r is not None]
    figures = {
        'arms': {name: _tally([arm[name] for arm in arms]) for name in (arms[0] if arms else ())},
        'smooth_directions': {
            'cases': len(ranks),
            'directions': _DIRECTIONS,
            'effect_beats_all': sum(rank['beaten_by'] == 0 for rank in ranks),
            'each': ranks,
        },
    }
    print(figures['arms'])
    print({k: v for k, v in figures['smooth_directions'].items() if k != 'each'})
    print(write('controls', figures))
    return 0


def _tally(results: Sequence[dict[str, Any]]) -> dict[str, Any]:
    chances = [float(r['p_value']) for r in results]
    return {
        'cases': len(results),
        'alarms': sum(r['verdict'] == 'disagree' for r in results),
        'below_margin': sum(r['verdict'] == 'below_margin' for r in results),
        'chance_below_0.003': sum(p < 0.003 for p in chances),
        'median_chance': float(np.median(chances)),
    }


def _arms(case: Path) -> dict[str, dict[str, Any]]:
    """Judge one clean case four ways."""
    from diffcal_ros.diagnosis.nominal_fit import fit_nominal
    from diffcal_ros.offline.calibrate_recordings import open_inputs
    from diffcal_ros.scene.load import load_scene

    inputs = open_inputs(load_scene(case / 'scene.yaml'), [], pose_source='stored')
    random = np.random.default_rng(sum(case.name.encode()))
    evaluator, nominal = fit_nominal(inputs.scene, inputs.observations, None)
    views = evaluator.model.views(nominal.coordinates)
    exact = [_image(o.depth.shape, v) for o, v in zip(inputs.observations, views, strict=True)]

    def seen(error: Callable[[tuple[int, ...]], FloatArray]) -> list[Any]:
        return [
            _watched(observation, depth, error(depth.shape), random)
            for observation, depth in zip(inputs.observations, exact, strict=True)
        ]

    def smooth(shape: tuple[int, ...]) -> FloatArray:
        field = gaussian_filter(random.standard_normal(shape), _LENGTH)
        return _SMOOTH * field / field.std()

    return {
        'independent': _judged(evaluator, nominal),
        'independent, mesh not allowed for': _judged(*_without_mesh(evaluator, nominal)),
        'same mesh': _judged_of_this_mesh(inputs.scene, seen(np.zeros)),
        'same mesh, smooth error': _judged_of_this_mesh(inputs.scene, seen(smooth)),
    }


def _judged_of_this_mesh(scene: Any, observations: list[Any]) -> dict[str, Any]:
    """Judge data of the fit's own mesh: what a finer one would change must not be taken off."""
    from diffcal_ros.diagnosis.nominal_fit import fit_nominal

    return _judged(*_without_mesh(*fit_nominal(scene, observations, None)))


def _without_mesh(evaluator: Any, nominal: Any) -> tuple[Any, Any]:
    """Refit without what is known of the mesh."""
    from diffcal_ros.diagnosis.patch_fits.refit import refit
    from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator

    still = tuple(np.zeros_like(move) for move in evaluator.discretisation_error.moves)
    nothing = replace(evaluator.discretisation_error, moves=still)
    without = PatchEvaluator(
        evaluator.model, evaluator.comparers, nothing, evaluator.cell, evaluator.left_out
    ).with_measured_noise(nominal.coordinates)
    return without, refit(without, nominal.coordinates)


def _judged(evaluator: Any, nominal: Any) -> dict[str, Any]:
    """Judge a nominal fit."""
    from diffcal_ros.diagnosis.detection.disagreement import measure_disagreement
    from diffcal_ros.diagnosis.screening.candidates import candidates
    from diffcal_ros.diagnosis.screening.screening import screen

    scores = screen(evaluator, nominal.coordinates, candidates(evaluator.model.scene))
    found = measure_disagreement(nominal, scores, margin=0.0005)
    return {'verdict': found.verdict.value, 'p_value': found.p_value}


def _image(shape: tuple[int, ...], view: Any) -> FloatArray:
    image = np.full(shape, np.nan)
    image[view.trace.rows, view.trace.columns] = view.trace.depth
    return image


def _watched(
    observation: Any, depth: FloatArray, error: FloatArray, random: np.random.Generator
) -> Any:
    """Take as many frames of a rendered image as the observation has, and fuse them."""
    from diffcal_ros.calibration.observations.observation import fuse_frames
    from diffcal_ros.depth_frame import DepthFrame

    frames = []
    for number in range(observation.frame_count):
        seen = depth + error + _NOISE * random.standard_normal(depth.shape)
        steps = (_STEP * np.round(seen / _STEP)).astype(np.float32)
        frames.append(DepthFrame(steps, number))
    fused = fuse_frames(frames)
    return replace(observation, depth=fused.depth, noise=fused.noise)


def _rank(case: Path) -> dict[str, Any] | None:
    """Let the best scored effect compete with random smooth directions; None where all agrees."""
    from diffcal_ros.diagnosis.detection.disagreement import measure_disagreement
    from diffcal_ros.diagnosis.nominal_fit import fit_nominal
    from diffcal_ros.diagnosis.patches.whitened import Part, whiten
    from diffcal_ros.diagnosis.screening.candidates import candidates
    from diffcal_ros.diagnosis.screening.screening import screen
    from diffcal_ros.offline.calibrate_recordings import open_inputs
    from diffcal_ros.scene.load import load_scene

    inputs = open_inputs(load_scene(case / 'scene.yaml'), [], pose_source='stored')
    evaluator, nominal = fit_nominal(inputs.scene, inputs.observations, None)
    scores = screen(evaluator, nominal.coordinates, candidates(inputs.scene))
    if not measure_disagreement(nominal, scores, margin=0.0005).is_worth_naming:
        return None
    smooth = [s for s in scores.scores if s.candidate.identifier != 'contact_plane']
    best = max(smooth, key=lambda score: score.plain_gain)
    count = best.plain_columns.shape[1]
    random = np.random.default_rng(sum(case.name.encode()))
    fields = _random_fields(evaluator, nominal, count * _DIRECTIONS, random)
    groups = evaluator.groups(nominal.coordinates, fields)
    columns = scores.project(whiten(groups, Part.FIT).jacobian[:, len(nominal.coordinates) :])
    own = _explained(best.plain_columns, best.plain_residual)
    others = [
        _explained(columns[:, count * k : count * (k + 1)], best.plain_residual)
        for k in range(_DIRECTIONS)
    ]
    return {
        'case': case.name,
        'effect': best.candidate.identifier,
        'amplitudes': count,
        'gain': own,
        'best_direction': max(others),
        'beaten_by': sum(other > own for other in others),
    }


def _explained(columns: FloatArray, residual: FloatArray) -> float:
    found, *_ = np.linalg.lstsq(columns, residual, rcond=1e-9)
    return float(residual @ residual - ((residual - columns @ found) ** 2).sum())


def _random_fields(
    evaluator: Any, nominal: Any, count: int, random: np.random.Generator
) -> list[FloatArray]:
    """Draw smooth motions of the body's points, zero at the clamp, (count, N, 3) each view.

    They are the same in the body's frame in every pose, as those of a cause in the body would be.
    """
    model = evaluator.model
    powers = random.standard_normal((count, 3, (_WIGGLES + 1) ** 3))
    fields = []
    for observation in model.observations:
        axes = model.effects.axes(observation.setup_index)
        rest = model.body(observation).discretisation.rest_nodes
        local = (rest - axes.root) @ axes.axes.T / axes.length
        terms = np.stack(
            [
                local[:, 0] ** i * local[:, 1] ** j * local[:, 2] ** k
                for i in range(_WIGGLES + 1)
                for j in range(_WIGGLES + 1)
                for k in range(_WIGGLES + 1)
            ]
        )
        held = axes.fraction(rest)
        moves = np.einsum('cat,tn->cna', powers, terms) * held[None, :, None]
        turn = observation.depth_from_world[:3, :3] @ axes.axes.T
        fields.append(0.01 * moves @ turn.T)
    return fields


if __name__ == '__main__':
    sys.exit(main())
