# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Equilibria, gradients, rendered depth, whole fits and live frames on a GPU beside the processor.

    DIFFCAL_DATA=DATASET python benchmarks/gpu.py [--bodies N] [--fits N] [--device cuda:0]

Seconds by the clock, and how far the two agree. Where there is no GPU nothing is run, and no file
is written.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace
import math
from pathlib import Path
import tempfile
import time
from typing import Any

from depth import CAMERA
from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.tracking.tracker import Tracker
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.linear_solvers import make_solver
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.sections.mesh_files import read_mesh
from diffcal_ros.tet_mesh import TetMesh
from diffcal_ros.warp_runtime.device_array import device_names
from equilibrium import GRAVITY, MODULUS, uniform_material
from large_bodies import BODIES, body_mesh, refined
from measuring import write
import meshio
import numpy as np
import warp as wp
import yaml

POSE = transform(rotation_matrix(np.array([0.25, -0.2, 0.1])), np.array([0.01, -0.02, 0.44]))
SAMPLE = Path(__file__).resolve().parents[1] / 'bags' / 'sample'
# Each tetrahedron of the sample's body is cut into eight so often.
FITS = (0, 1)
# Frames that are followed after each fit, and the time between them at 30 Hz [ns].
FOLLOWED, FRAME_NS = 120, 33_333_333


def seconds(work: Callable[[], Any], repeats: int = 1) -> float:
    """Return the least time that a call takes [s]."""
    least = math.inf
    for _ in range(repeats):
        begun = time.perf_counter()
        work()
        least = min(least, time.perf_counter() - begun)
    return least


def measure(
    mesh: TetMesh, device: str, solver: str, repeats: int
) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    """Settle one body; return figures, where it rests [m], (N, 3), and by moduli, (T,)."""
    held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
    begun = time.perf_counter()
    body = StaticBody(mesh, Element.QUADRATIC, held, device=device, solver=solver)
    figures: dict[str, Any] = {'set_up': time.perf_counter() - begun}
    first, second = (uniform_material(mesh.tet_count, factor * MODULUS) for factor in (1.0, 1.05))
    ones = np.ones_like(body.discretisation.rest_nodes)

    def settle() -> None:
        body.forget()
        body.solve_equilibrium(first, GRAVITY)
        body.gradient(ones)

    figures['solver'] = body.solver.stiffness.solver_name
    figures['cold'] = seconds(settle, repeats)
    rest, by_moduli = body.state.positions, body.gradient(ones).youngs_modulus
    tangent = body.tangents([Change(youngs_modulus=first.youngs_modulus)])[0]

    def follow() -> None:
        body.solve_equilibrium(second, GRAVITY, prediction=math.log(1.05) * tangent)
        body.gradient(ones)

    figures['warm'] = seconds(follow)
    stiffness, positions = body.solver.stiffness, body.own_state.positions
    values = stiffness.values(positions)
    engine = make_solver(stiffness.pattern, solver, device=device)
    figures['assembly'] = seconds(lambda: stiffness.values(positions), 3)
    figures['factor'] = seconds(lambda: engine.factor(values), 2)
    side = np.ones(stiffness.pattern.size)
    figures['solve'] = seconds(lambda: engine.solve(side), 3)
    figures['stiffness_product'] = seconds(
        lambda: stiffness.force_tangent(positions, positions), 10
    )
    tracer = DepthTracer(
        body.discretisation.surface_triangles, len(positions), CAMERA, device=device
    )
    points = apply(POSE, rest)

    def render() -> None:
        area = tracer.trace(points).area_image(side=8)
        area.pull_back(area.image)

    render()
    figures['depth_and_gradient'] = seconds(render, 10)
    return figures, rest, by_moduli


def compare(mesh: TetMesh, device: str, repeats: int) -> dict[str, Any]:
    """Settle one body on the processor, and on the GPU with both solvers."""
    figures, expected, expected_by_moduli = measure(mesh, 'cpu', 'auto', repeats)
    row: dict[str, Any] = {'tets': mesh.tet_count, 'cpu': figures}
    for solver in ('multifrontal', 'multifrontal_torch'):
        there, found, by_moduli = measure(mesh, device, solver, repeats)
        row[f'{device} {solver}'] = {
            **there,
            'times_as_fast': {
                key: figures[key] / there[key] for key in figures if key != 'solver'
            },
            'largest_difference_m': float(np.abs(found - expected).max()),
            'gradient_differs_by': float(
                np.abs(by_moduli - expected_by_moduli).max() / np.abs(expected_by_moduli).max()
            ),
        }
    return row


def refined_sample(folder: Path, refinements: int) -> Path:
    """Write the sample's scene with a finer mesh of the same body; return its path."""
    scene = yaml.safe_load((SAMPLE / 'scene.yaml').read_text())
    mesh = refined(read_mesh(SAMPLE / scene['mesh']['file'], unit='mm').mesh, refinements)
    name = f'finger_{refinements}.vtk'
    meshio.write_points_cells(folder / name, 1e3 * mesh.rest_positions, [('tetra', mesh.tets)])
    scene['mesh']['file'] = name
    path = folder / f'scene_{refinements}.yaml'
    path.write_text(yaml.safe_dump(scene))
    return path


def fit(scene: Path, device: str) -> dict[str, Any]:
    """Calibrate the sample."""
    inputs = open_inputs(load_scene(scene), [SAMPLE / 'bag'])
    begun = time.perf_counter()
    calibration = Calibration(
        inputs.scene,
        inputs.observations,
        CalibrationSettings(with_mesh_error=False, device=device),
    )
    result = calibration.run()
    told = result.parameters[0]
    figures = {
        'seconds': time.perf_counter() - begun,
        'iterations': result.iterations,
        'outcome': result.outcome.value,
        'parameter': told.name,
        'value': told.value,
        'std_error': told.std_error,
    }
    return {**figures, 'live': follow(calibration, result)}


def follow(calibration: Calibration, result: CalibrationResult) -> dict[str, Any]:
    """Follow the body from frame to frame as the live node does, the sample's in a loop."""
    tracker = Tracker(calibration, result.parameters)
    frames = list(open_recording(SAMPLE / 'bag').depth_frames())
    took = []
    for number in range(FOLLOWED):
        frame = replace(frames[number % len(frames)], stamp_ns=number * FRAME_NS)
        begun = time.perf_counter()
        tracker.follow(frame)
        took.append(time.perf_counter() - begun)
    # The first frames move the view that the fit ended with.
    settled = np.array(took[FOLLOWED // 4 :])
    return {
        'frames': len(settled),
        'p50_ms': 1e3 * float(np.median(settled)),
        'p99_ms': 1e3 * float(np.quantile(settled, 0.99)),
        'within_a_frame': float((settled < 1e-9 * FRAME_NS).mean()),
    }


def main() -> None:
    """Run every body, then every fit, on the processor and on the GPU."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--device', default='cuda:0')
    parser.add_argument('--repeats', type=int, default=1)
    parser.add_argument('--bodies', nargs='*', choices=[*BODIES], default=[*BODIES])
    parser.add_argument('--fits', nargs='*', type=int, default=[*FITS])
    parser.add_argument('--name', default='gpu')
    arguments = parser.parse_args()
    if arguments.device not in device_names():
        raise SystemExit(
            f'NOTHING WAS RUN: this machine has no {arguments.device}, but '
            f'{", ".join(device_names())}; no file was written'
        )
    figures: dict[str, Any] = {'device': arguments.device, 'gpu': gpu_name(arguments.device)}
    rows: dict[str, Any] = {}
    fits: dict[str, Any] = {}
    # Kernels are compiled beforehand: what that takes is told by itself.
    coarse = body_mesh('coarse')
    figures['first_s'] = {
        device: seconds(lambda device=device: measure(coarse, device, 'auto', 1))
        for device in ('cpu', arguments.device)
    }
    for name in arguments.bodies:
        rows[name] = compare(body_mesh(name), arguments.device, arguments.repeats)
        write(arguments.name, {**figures, 'rows': rows})
    with tempfile.TemporaryDirectory() as folder:
        for refinements in arguments.fits:
            scene = refined_sample(Path(folder), refinements)
            fits[f'sample refined {refinements} times'] = {
                device: fit(scene, device) for device in (arguments.device, 'cpu')
            }
            write(arguments.name, {**figures, 'rows': rows, 'fits': fits})


def gpu_name(device: str) -> str:
    """Return what Warp calls the device."""
    return str(wp.get_device(device).name)


if __name__ == '__main__':
    main()
