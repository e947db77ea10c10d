# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A released cantilever: speed, memory, order, agreement and gradients of both integrators."""

import argparse
from collections.abc import Callable
import json
from pathlib import Path
import subprocess
import sys
import time
from typing import Any

from diffcal_ros.damping import Damping
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion.inputs import MotionChange, Release
from diffcal_ros.fem.motion.moving_body import Motion, MovingBody
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import LameConvention, Material
from measuring import cantilevers, timed, write
import numpy as np

GRAVITY = np.array([0.0, 9.8, 0.0])
MU, BETA, DENSITY = 69.27e3, 10.0, 1080.0
STAMPS = np.arange(1, 13) / 30.0  # 0.4 s at 30 Hz.
# Just below what Newton physics and `stable_step` find stable for this mesh [s].
EXPLICIT_STEP = 2.0e-5
# Central differences at these shares of a parameter, and of so many seconds for the release:
# frames lie on the ends of steps, where the motion's second derivative jumps.
DIFFERENCES = (4e-3, 2e-3)
RELEASE_SHARE = 2.5e-3


class Cantilever:
    """The public cantilever, held at one end and let go at the other."""

    def __init__(self, mesh: Any, *, solver: str = 'auto', **options: Any) -> None:
        held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
        ledge = np.flatnonzero(mesh.rest_positions[:, 0] <= -0.09 + 1e-9).astype(np.int32)
        self.mesh, self.held = mesh, held
        element = options.pop('element', Element.LINEAR)
        static = StaticBody(mesh, element, held, solver=solver)
        self.body = MovingBody(static, Release(ledge, 0.0), **options)
        self.tip = int(np.argmin(mesh.rest_positions[:, 0]))
        ones = np.ones(mesh.tet_count)
        self.values = {
            'youngs_modulus': 2.0 * MU * 1.49 * ones,
            'damping': BETA * ones,
            'density': DENSITY * ones,
            'release_time': 0.0,
        }

    def run(self, stamps: Any = STAMPS, **changed: Any) -> Motion:
        """Simulate, with some values changed."""
        now = {**self.values, **changed}
        nu = np.full(self.mesh.tet_count, 0.49)
        material = Material(now['youngs_modulus'], nu, now['density'], LameConvention.PAPER)
        return self.body.simulate(
            material, Damping(now['damping']), GRAVITY, stamps, release_time=now['release_time']
        )

    def tip_gradient(self, motion: Motion) -> Any:
        """Pull the tip's height over all frames back."""
        by_positions = np.zeros_like(motion.positions)
        by_positions[:, self.tip, 1] = 1.0
        return self.body.gradient(by_positions)

    def slopes(self, motion: Motion) -> dict[str, float]:
        """Return the tip's derivative by the logarithm of each value, or by the release time."""
        gradient = self.tip_gradient(motion)
        return {
            'youngs_modulus': float(gradient.youngs_modulus @ self.values['youngs_modulus']),
            'damping': float(gradient.damping @ self.values['damping']),
            'density': float(gradient.density @ self.values['density']),
            'release_time': gradient.release_time,
        }

    def difference_slope(self, name: str, share: float) -> float:
        """Return the same by a central difference."""
        heights = []
        for sign in (1.0, -1.0):
            if name == 'release_time':
                step = RELEASE_SHARE * share
                motion = self.run(release_time=sign * step)
            else:
                step = share
                motion = self.run(**{name: self.values[name] * (1.0 + sign * share)})
            heights.append(float(motion.positions[:, self.tip, 1].sum()))
        return (heights[0] - heights[1]) / (2.0 * step)


def speed(mesh: Any, solver: str, repeats: int) -> dict[str, Any]:
    """Time the implicit integrator over 0.4 s."""
    case = Cantilever(mesh, solver=solver)
    changes = [
        MotionChange(youngs_modulus=case.values['youngs_modulus']),
        MotionChange(damping=case.values['damping']),
        MotionChange(density=case.values['density']),
        MotionChange(release_time=1.0),
    ]
    motion = case.run()
    case.tip_gradient(motion)
    forward = timed(case.run, repeats=repeats)
    backward = timed(lambda: case.tip_gradient(motion), repeats=repeats)
    return {
        'solver': case.body.static_body.solver.stiffness.solver_name,
        'tets': mesh.tet_count,
        'steps': motion.step_count,
        'halvings': motion.halvings,
        'forward': forward,
        'gradient': backward,
        'forward_and_gradient_s': forward['median_s'] + backward['median_s'],
        'forward_and_gradient_fastest_s': forward['fastest_s'] + backward['fastest_s'],
        'four_tangents': timed(lambda: case.body.tangents(changes), repeats=max(repeats // 3, 1)),
    }


def explicit_speed(mesh: Any) -> dict[str, Any]:
    """Time our own semi-implicit path once."""
    case = Cantilever(mesh, integrator='semi_implicit', time_step=EXPLICIT_STEP)
    case.run(np.array([0.001]))
    begun = time.perf_counter()
    motion = case.run()
    forward = time.perf_counter() - begun
    case.tip_gradient(motion)
    total = time.perf_counter() - begun
    return {'steps': motion.step_count, 'forward_s': forward, 'forward_and_gradient_s': total}


def memory(mesh_name: str, duration: float) -> dict[str, Any]:
    """Measure one march and its gradient in a process of its own."""
    command = [sys.executable, __file__, '--memory', mesh_name, str(duration)]
    found = subprocess.run(command, capture_output=True, text=True, check=True)
    row: dict[str, Any] = json.loads(found.stdout.strip().splitlines()[-1])
    return row


def measure_memory(mesh_name: str, duration: float) -> dict[str, Any]:
    """Tell by how much the resident memory grows above that before the motion."""
    mesh = cantilevers()[mesh_name]
    case = Cantilever(mesh)
    case.tip_gradient(case.run(np.array([0.02])))
    before = _resident_bytes('VmRSS')
    Path('/proc/self/clear_refs').write_text('5')  # The peak starts anew from what is resident.
    begun = time.perf_counter()
    motion = case.run(np.arange(1, round(duration * 30) + 1) / 30.0)
    case.tip_gradient(motion)
    return {
        'mesh': mesh_name,
        'tets': mesh.tet_count,
        'duration_s': duration,
        'steps': motion.step_count,
        'grown_mb': (_resident_bytes('VmHWM') - before) / 1e6,
        'seconds': time.perf_counter() - begun,
    }


def _resident_bytes(name: str) -> int:
    for line in Path('/proc/self/status').read_text().splitlines():
        if line.startswith(name):
            return 1024 * int(line.split()[1])
    raise RuntimeError(f'/proc/self/status has no {name}: memory is measured on Linux only')


def bias(mesh: Any) -> dict[str, Any]:
    """Tell what the default step's own error would be taken for in a fit of the whole path.

    The density stays: stiffness, damping and density scaled together move alike.
    """
    case, fine = Cantilever(mesh), Cantilever(mesh, time_step=1.0 / 3840.0)
    error = case.run().positions - fine.run().positions
    fields = {
        'youngs_modulus': MotionChange(youngs_modulus=case.values['youngs_modulus']),
        'damping': MotionChange(damping=case.values['damping']),
    }
    tangents = case.body.tangents(list(fields.values()))
    found = np.linalg.lstsq(tangents.reshape(len(fields), -1).T, -error.ravel(), rcond=None)[0]
    row: dict[str, Any] = dict(zip(fields, found.tolist(), strict=True))
    row['tip_path_mm'] = 1e3 * float(np.linalg.norm(error[:, case.tip], axis=1).max())
    return row


def order(mesh: Any) -> dict[str, Any]:
    """Halve the step twice and compare paths between frames."""
    rows = {}
    for name, steps in (
        ('implicit', (1 / 960, 1 / 1920, 1 / 3840)),
        ('semi_implicit', (2e-5, 1e-5, 5e-6)),
    ):
        stamps = STAMPS if name == 'implicit' else STAMPS[:3]
        paths = []
        for step in steps:
            case = Cantilever(mesh, integrator=name, time_step=step)
            paths.append(case.run(stamps).positions[:, case.tip])
        errors = [float(np.linalg.norm(paths[i] - paths[i + 1])) for i in (0, 1)]
        rows[name] = {'steps': steps, 'differences_m': errors}
        rows[name]['slope'] = float(np.log2(errors[0] / errors[1]))
    return rows


def gradients(case: Cantilever, names: tuple[str, ...]) -> dict[str, Any]:
    """Compare the gradient with differences."""
    slopes = case.slopes(case.run())
    rows = {}
    for name in names:
        differences = [case.difference_slope(name, share) for share in DIFFERENCES]
        # Central differences err by the square of the step: their limit is extrapolated.
        limit = (4.0 * differences[1] - differences[0]) / 3.0
        rows[name] = {'gradient': slopes[name], 'relative_error': limit / slopes[name] - 1.0}
    return rows


def agreement(mesh: Any) -> dict[str, Any]:
    """Compare both integrators in the limit of small steps."""
    fine = Cantilever(mesh, time_step=1.0 / 3840.0)
    other = Cantilever(mesh, integrator='semi_implicit', time_step=EXPLICIT_STEP)
    motions = [case.run() for case in (fine, other)]
    paths = [m.positions[:, fine.tip] for m in motions]
    slopes = [c.slopes(m) for c, m in zip((fine, other), motions, strict=True)]
    return {
        'tip_path_mm': 1e3 * float(np.linalg.norm(paths[0] - paths[1], axis=1).max()),
        'gradients': {name: slopes[1][name] / slopes[0][name] - 1.0 for name in slopes[0]},
    }


def main() -> None:
    """Run the studies that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--solvers', nargs='+', default=['qdldl'])
    parser.add_argument('--repeats', type=int, default=9)
    parser.add_argument('--memory', nargs=2, metavar=('MESH', 'SECONDS'))
    arguments = parser.parse_args()
    if arguments.memory:
        print(json.dumps(measure_memory(arguments.memory[0], float(arguments.memory[1]))))
        return
    mesh = cantilevers()['coarse']
    names = ('youngs_modulus', 'damping', 'density', 'release_time')
    explicit = Cantilever(mesh, integrator='semi_implicit', time_step=EXPLICIT_STEP)
    studies: dict[str, Callable[[], Any]] = {
        'implicit': lambda: [speed(mesh, name, arguments.repeats) for name in arguments.solvers],
        'semi_implicit': lambda: explicit_speed(mesh),
        'memory': lambda: [
            *(memory('coarse', duration) for duration in (0.4, 1.0, 2.5, 5.0, 10.0)),
            *(memory('fine', duration) for duration in (0.4, 1.0)),
        ],
        'order': lambda: order(mesh),
        'bias_of_default_step': lambda: bias(mesh),
        'agreement': lambda: agreement(mesh),
        'gradients_implicit': lambda: gradients(Cantilever(mesh), names),
        'gradients_semi_implicit': lambda: gradients(explicit, names),
    }
    figures: dict[str, Any] = {}
    for name, study in studies.items():
        figures[name] = study()
        print(name, figures[name], flush=True)
    best = min(row['forward_and_gradient_s'] for row in figures['implicit'])
    explicit_row = figures['semi_implicit']
    explicit_row['ratio'] = explicit_row['forward_and_gradient_s'] / best
    write('motion', figures)


if __name__ == '__main__':
    main()
