# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Calibrate the modulus of one synthetic depth image.

The image shows the beam on a finer mesh than the one that is fitted, with the noise and the steps
of a LIDAR camera. No file is needed beside the scene: an `Observation` is a depth image, a camera
and its pose.

Printed: Young's modulus with its standard error, the truth, the gap before and after, and the
outcome. The error contains what a finer mesh would change.
"""

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
    calibrate,
    DepthTracer,
    Element,
    load_scene,
    Material,
    Observation,
    StaticBody,
)
import numpy as np

TRUTH, START = 150e3, 300e3  # [Pa]

mesh = beam_mesh((10, 3, 3))
ones = np.ones(mesh.tet_count)
body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh))
body.solve_equilibrium(Material(TRUTH * ones, 0.45 * ones, 1080.0 * ones), GRAVITY)
points = points_in_camera(body)
tracer = DepthTracer(body.discretisation.surface_triangles, len(points), CAMERA)
depth = tracer.trace(points).full_depth()
noise = np.random.default_rng(3).normal(scale=0.00014, size=depth.shape)
measured = (np.round((depth + noise) / 0.00025) * 0.00025).astype(np.float32)

with TemporaryDirectory() as folder:
    scene = load_scene(write_scene(Path(folder), START))
result = calibrate(scene, [Observation('image', 0, measured, CAMERA, DEPTH_FROM_WORLD)])
modulus = result['youngs_modulus']

print(f'fitted   {1e-3 * modulus.value:6.1f} +- {1e-3 * modulus.std_error:.1f} kPa')
print(f'truth    {1e-3 * TRUTH:6.1f} kPa')
print(f'gap      {1e3 * result.gap_start.median:.3f} -> {1e3 * result.gap_end.median:.3f} mm')
print(f'outcome  {result.outcome.value}')
