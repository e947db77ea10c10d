# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Have a hidden effect named.

Eight frames show the beam with a depth camera that reads three millimetres too far, which the
scene does not say. A diagnosis sees that simulation and measurement disagree, refits the model
with each effect of the library that might do, and tells which of them explain patches of the
images that no refit has seen. One pose hardly tells a camera that reads too far from one that
stands elsewhere: the verdict says what comes next, and what would settle it.

Printed: what a person reads, and the modulus before and after.
"""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from beam import (
    beam_mesh,
    CAMERA,
    DEPTH_FROM_WORLD,
    GRAVITY,
    held_end,
    points_in_camera,
    write_scene,
)
from diffcal_ros import (
    DepthTracer,
    diagnose,
    Element,
    load_scene,
    Material,
    Observation,
    StaticBody,
)
from diffcal_ros.calibration.observations.observation import fuse_frames
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.report.tables.verdict_text import verdict_lines
import numpy as np

TRUTH, BIAS, FRAMES = 150e3, 0.003, 8  # [Pa], [m]
random = np.random.default_rng(4)

mesh = beam_mesh((10, 3, 3))
ones = np.ones(mesh.tet_count)
body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh))
body.solve_equilibrium(Material(TRUTH * ones, 0.45 * ones, 1080.0 * ones), GRAVITY)
points = points_in_camera(body)
tracer = DepthTracer(body.discretisation.surface_triangles, len(points), CAMERA)
depth = tracer.trace(points).full_depth() + BIAS


def frame(number: int) -> DepthFrame:
    """Read the depth as a LIDAR camera does, with noise and in steps."""
    noisy = depth + random.normal(scale=0.00014, size=depth.shape)
    return DepthFrame((np.round(noisy / 0.00025) * 0.00025).astype(np.float32), number)


fused = fuse_frames([frame(number) for number in range(FRAMES)])
seen = replace(
    Observation('still', 0, fused.depth, CAMERA, DEPTH_FROM_WORLD),
    frame_count=FRAMES,
    noise=fused.noise,
)
with TemporaryDirectory() as folder:
    scene = load_scene(write_scene(Path(folder), 200e3))
verdict = diagnose(scene, [seen]).diagnosis

print('\n'.join(verdict_lines(verdict)))
before, after = (verdict.parameters[when]['youngs_modulus'] for when in ('before', 'after'))
print(f'modulus {before["value"]:.0f} -> {after["value"]:.0f} Pa, truth {TRUTH:.0f} Pa')
