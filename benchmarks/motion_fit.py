# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Twelve frames of a released cantilever, fitted from ten random starts.

The true body has another, finer mesh and moves by semi-implicit Euler; the fit has the implicit
integrator. Images are noisy, and stamps jitter.
"""

from dataclasses import replace
from pathlib import Path
import tempfile
import time
from typing import Any

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.recorder import record, RecorderSettings
from live_scene import write_scene
from measuring import write
import numpy as np
import yaml

TRUTH = {'youngs_modulus': 120e3, 'damping': 150.0, 'density': 1080.0, 'release_time': 0.08}
# Motion under gravity shows only ratios to the density: the body was weighed, not quite right.
WEIGHED = {'mean': 1090.0, 'std': 20.0}
# Linear elements are far too stiff in bending: one start shows what they cost.
STARTS = {Element.QUADRATIC: 10, Element.LINEAR: 1}
SPREAD = {'youngs_modulus': 0.45, 'damping': 0.9, 'density': 0.3}  # Of the logarithm.
RELEASE_SPREAD = 0.03  # [s]
FRAMES, RATE, JITTER = 12, 30.0, 2e-4
TRUE_CELLS, CELLS = (16, 5, 4), (12, 3, 3)
CLAMP = 0.12  # Where the body enters it, a plane of both meshes [m].
CAMERA = PinholeCamera(640, 480, fx=457.0, fy=458.0, cx=322.0, cy=243.0)


def main() -> None:
    """Film once, and fit with each element."""
    with tempfile.TemporaryDirectory() as name:
        scene, observations = film(Path(name))
    figures: dict[str, Any] = {
        'truth': TRUTH,
        'weighed': WEIGHED,
        'frames': FRAMES,
        'rate_hz': RATE,
        'stamp_jitter_s': JITTER,
        'tets': scene.mesh.tet_count,
        'tets_of_the_true_body': 6 * int(np.prod(TRUE_CELLS)),
    }
    for element, count in STARTS.items():
        figures[element.value] = study(replace(scene, element=element), observations, count)
        print(element.value, figures[element.value]['summary'], flush=True)
    write('motion_fit', figures)


def film(folder: Path) -> tuple[Scene, tuple[Observation, ...]]:
    """Film the true body; return the scene of the fit and its frames."""
    settings = RecorderSettings(
        timing=Timing(FRAMES, RATE, stamp_jitter=JITTER),
        color_frames=0,
        integrator='semi_implicit',
        depth_camera=CAMERA,
        seed=11,
    )
    true_scene = load_scene(released_scene(folder / 'true', TRUE_CELLS))
    made = record(true_scene, folder / 'filmed', settings)
    document = yaml.safe_load(made.scene.read_text())
    other = released_scene(folder / 'fit', CELLS)
    # What the recorder wrote, on the other mesh.
    document['bag'] = str(made.bags['observation'])
    other.write_text(yaml.safe_dump(document))
    scene = load_scene(other)
    return scene, open_inputs(scene, [], pose_source='stored').observations


def released_scene(folder: Path, cells: tuple[int, int, int]) -> Path:
    """Write the live benchmark's cantilever with a ledge under its free end."""
    path = write_scene(folder, Element.QUADRATIC, cells)
    document = yaml.safe_load(path.read_text())
    document['held'] = {
        'clamp': {'box': {'x': [CLAMP - 1e-6, float('inf')]}},
        'ledge': {'box': {'x': [-float('inf'), 0.0]}},
    }
    document['motion'] = {
        'released': ['ledge'],
        'at': {'start': TRUTH['release_time'], 'min': 0.02, 'max': 0.2},
        'hold_out': 0,
    }
    body = document['regions']['body']
    body['youngs_modulus'] = TRUTH['youngs_modulus']
    body['damping'] = TRUTH['damping']
    body['density'] = {'start': TRUTH['density'], 'prior': WEIGHED}
    document['fit'] = ['youngs_modulus', 'damping', 'density', 'release_time', 'rigid_offset']
    path.write_text(yaml.safe_dump(document, sort_keys=False))
    return path


def study(scene: Scene, observations: tuple[Observation, ...], starts: int) -> dict[str, Any]:
    """Fit from every start and compare."""
    random = np.random.default_rng(20231)
    results, seconds = [], []
    for number in range(starts):
        begun = time.perf_counter()
        # What a finer mesh would change is the same for all: it is asked for once.
        settings = CalibrationSettings(with_mesh_error=number == 0)
        results.append(calibrate(started(scene, random), observations, settings))
        seconds.append(time.perf_counter() - begun)
        print(number, results[-1].iterations, results[-1].values(), flush=True)
    return {
        'summary': summary(results),
        'iterations': [result.iterations for result in results],
        'seconds': seconds,
        'outcomes': [result.outcome.value for result in results],
        'starts': [{name: result[name].start for name in TRUTH} for result in results],
        'found': [{name: result[name].value for name in TRUTH} for result in results],
        'gap_median_mm': [1e3 * result.gap_end.median for result in results],
    }


def started(scene: Scene, random: np.random.Generator) -> Scene:
    """Return the scene with random start values around the truth."""
    (region,), (setup,) = scene.regions, scene.observations
    assert setup.motion is not None
    changed = {
        name: replace(
            getattr(region, name), start=TRUTH[name] * np.exp(random.uniform(-spread, spread))
        )
        for name, spread in SPREAD.items()
    }
    late = random.uniform(-RELEASE_SPREAD, RELEASE_SPREAD)
    release = replace(setup.motion.release_time, start=TRUTH['release_time'] + late)
    motion = replace(setup.motion, release_time=release)
    return replace(
        scene,
        regions=(replace(region, **changed),),
        observations=(replace(setup, motion=motion),),
    )


def summary(results: list[CalibrationResult]) -> dict[str, Any]:
    """Compare the answers with the truth and with one another; errors are the first fit's."""
    first = results[0]
    rows: dict[str, Any] = {'most_iterations': max(result.iterations for result in results)}
    for name, true in TRUTH.items():
        values = np.array([result[name].value for result in results])
        low, high = first[name].interval_95
        rows[name] = {
            'mean': float(values.mean()),
            'relative_error': float(values.mean() / true - 1.0),
            'spread_of_starts': float(np.ptp(values) / values.mean()),
            'interval_95': [low, high],
            'half_width': float(0.5 * (high - low) / first[name].value),
            'truth_inside': bool(low < true < high),
            'std_error': first[name].std_error,
            'mesh_error': first[name].mesh_error,
        }
    return rows


if __name__ == '__main__':
    main()
