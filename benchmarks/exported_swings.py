# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How an exported body swings in MuJoCo and Newton, beside the body that was filmed.

    python benchmarks/exported_swings.py [--out DIR]

The cantilever of benchmarks/motion_fit.py, whose true body has another, finer mesh and moves by
another integrator, is let go and filmed for a second. It is calibrated, and exported thrice for
each simulator: with
the material's numbers, with moduli that were made for the simulator and the material's damping,
and with both made for it by its own swings. What is compared is the tip's height over 1.5 s.
Writes benchmarks/results/exported_swings.json.
"""

import argparse
from dataclasses import replace
import importlib.metadata
from pathlib import Path
import sys
from tempfile import TemporaryDirectory
import time
from typing import Any

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.forward.moving_posture import MovingPosture
from diffcal_ros.calibration.forward.posture import PostureInputs, RestingPosture
from diffcal_ros.export.effective.effective_fit import EffectiveFit
from diffcal_ros.export.effective.fit import fit_effective
from diffcal_ros.export.effective.simulators import find_simulator, find_swing
from diffcal_ros.export.effective_numbers import EffectiveNumbers, with_effective
from diffcal_ros.export.exported_body import exported_body, ExportedBody
from diffcal_ros.export.material_groups import material_groups
from diffcal_ros.export.players import play_newton
from diffcal_ros.export.targets import mjcf, newton
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.terms.conditions import NO_CONDITIONS
from diffcal_ros.material import Material
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.save import save_fitted_scene
from diffcal_ros.scene.start_material import start_constant, start_material
from diffcal_ros.tet_mesh import TetMesh
from measuring import write
import motion_fit
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

FloatArray = NDArray[np.float64]

SIMULATORS = ('mujoco', 'newton')
_FRAMES = 30
_TIMES = np.arange(1, 751) * 0.002  # Since the release [s].
_UP = 1  # The axis along which gravity pulls.


def main() -> int:
    """Film, calibrate, and swing; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--out', type=Path, help='keep what is filmed here, or take it from there')
    given = parser.parse_args()
    with TemporaryDirectory() as name:
        figures = _study(given.out or Path(name))
    write('exported_swings', figures)
    return 0


def _study(folder: Path) -> dict[str, Any]:
    motion_fit.FRAMES = _FRAMES
    written = folder / 'fit' / 'scene.yaml'
    if written.is_file():
        scene = load_scene(written)
        observations = open_inputs(scene, [], pose_source='stored').observations
    else:
        scene, observations = motion_fit.film(folder)
    calibration = Calibration(scene, observations)
    result = calibration.run()
    path = folder / 'fitted_scene.yaml'
    save_fitted_scene(scene, path, result.values())
    fitted = load_scene(path)
    filmed = load_scene(folder / 'true' / 'scene.yaml')
    figures: dict[str, Any] = {
        'filmed': swing_of(_own_heights(filmed)),
        'calibrated': swing_of(_own_heights(fitted)),
        'fitted': {
            name: [result[name].value, result[name].std_error]
            for name in ('youngs_modulus', 'damping')
        },
        'versions': {name: importlib.metadata.version(name) for name in SIMULATORS},
        'tetrahedra': scene.mesh.tet_count,
    }
    for name in SIMULATORS:
        begun = time.process_time()
        effective = fit_effective(calibration, result, fitted, find_simulator(name), report=print)
        figures[name] = _in_simulator(fitted, effective)
        figures[name]['fit_cpu_s'] = round(time.process_time() - begun, 1)
    return figures


def _in_simulator(fitted: Scene, effective: EffectiveFit) -> dict[str, Any]:
    """Export and swing with the material's numbers, effective moduli, and all of them."""
    body = exported_body(fitted, fitted.observations[0])
    found = effective.as_dict()
    moduli = {'': effective.moduli[0].effective}
    ratios = {name: own for name, (_, own) in effective.poissons_ratios.items()}
    dampings = {'': effective.dampings[0].effective}
    bodies = {
        'material': body,
        'effective_moduli': with_effective(body, EffectiveNumbers(moduli, ratios)),
        'effective': with_effective(body, EffectiveNumbers(moduli, ratios, dampings)),
    }
    figures: dict[str, Any] = {'numbers': found}
    for name, own in bodies.items():
        begun = time.process_time()
        heights = _heights(effective.simulator, fitted, own)
        figures[name] = {
            **swing_of(heights),
            'step_s': _step(effective.simulator, own),
            'cpu_s': round(time.process_time() - begun, 1),
        }
    return figures


def _heights(simulator: str, scene: Scene, body: ExportedBody) -> FloatArray:
    """Return the tip's height in a simulator [m], shape (S,)."""
    target = find_simulator(simulator)
    setup = scene.observations[0]
    law = find_law(target.law)
    linear = replace(scene, element=Element.LINEAR, law=target.law)
    own = RestingPosture(linear, setup, 'auto', 'cpu')
    material = Material(
        body.youngs_modulus, body.poissons_ratio, body.density, conversion=law.CONVERSION
    )
    own.body.solve_equilibrium(material, body.gravity)
    swing = find_swing(target)
    assert swing is not None
    return swing(body, own.body.state.positions, _TIMES)[:, _tip(body.mesh), _UP].mean(axis=1)


def _own_heights(scene: Scene) -> FloatArray:
    """Return the tip's height as this package simulates a scene's start values [m]."""
    posture = MovingPosture(scene, scene.observations[0], _TIMES.tolist(), 'auto', 'cpu')
    motion = scene.observations[0].motion
    assert motion is not None
    states = posture.solve(
        PostureInputs(
            start_material(scene),
            scene.observations[0].gravity,
            NO_CONDITIONS,
            damping=start_constant(scene, 'damping'),
            release_time=0.0,
        )
    )
    return states.positions[:, _tip(scene.mesh), _UP].mean(axis=1)


def _tip(mesh: TetMesh) -> NDArray[np.intp]:
    along = mesh.rest_positions[:, 0]
    return np.flatnonzero(along < along.min() + 1e-6)


def _step(simulator: str, body: ExportedBody) -> float:
    if simulator == 'mujoco':
        return mjcf.time_step(material_groups(body))
    return float(play_newton.stable_step(newton.arrays(body)))


def swing_of(heights: FloatArray) -> dict[str, float]:
    """Fit c + exp(-d t) (a cos w t + b sin w t) from the first low on."""
    first = int(np.argmin(heights))
    times, seen = _TIMES[first:] - _TIMES[first], heights[first:]

    def fitted(numbers: FloatArray) -> tuple[FloatArray, FloatArray]:
        decay, rate = numbers
        envelope = np.exp(-decay * times)
        columns = [np.ones_like(times), envelope * np.cos(rate * times)]
        basis = np.stack([*columns, envelope * np.sin(rate * times)], axis=1)
        factors, *_ = np.linalg.lstsq(basis, seen, rcond=None)
        return basis @ factors - seen, factors

    # The first low is half a period after the release.
    found = least_squares(lambda own: fitted(own)[0], [1.0, np.pi / _TIMES[first]])
    residual, (middle, cosine, sine) = fitted(found.x)
    return {
        'period_s': float(2.0 * np.pi / found.x[1]),
        'decay_per_s': float(found.x[0]),
        'first_low_mm': float(1e3 * (heights[first] - heights[0])),
        'rest_mm': float(1e3 * (middle - heights[0])),
        'amplitude_mm': float(1e3 * np.hypot(cosine, sine)),
        'amplitude_after_a_second_mm': float(1e3 * np.hypot(cosine, sine) * np.exp(-found.x[0])),
        'fit_rms_mm': float(1e3 * np.sqrt(np.mean(residual**2))),
    }


if __name__ == '__main__':
    sys.exit(main())
