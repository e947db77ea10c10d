# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth of a hanging beam, and what its outline adds to the derivative.

A pixel inside the body changes smoothly with the body. A pixel on the outline jumps between the
body and the background, and its derivative is an integral along the outline (Arnavaz et al. 2023,
equations 7 and 8). The tracer has both parts; leaving the second out gives a gradient that points
elsewhere.

Printed: how a weighted mean of the image follows when the body is shifted to the right, with
weights that grow from the left edge of the image to the right one. Hardly any depth inside the
body changes then: nearly all of the derivative comes from the outline.
"""

from beam import beam_mesh, CAMERA, GRAVITY, held_end, points_in_camera
from diffcal_ros import DepthTracer, Element, Material, StaticBody
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import pose_gradient
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

BACKGROUND = 0.5  # [m]
STEP = 2e-5  # [m]: 0.03 px.
TO_THE_RIGHT = np.array([1.0, 0.0, 0.0])
FINE = 128  # Samples a side of an outline pixel, for differences; the gradient takes its default.

mesh = beam_mesh()
ones = np.ones(mesh.tet_count)
body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh))
body.solve_equilibrium(Material(150e3 * ones, 0.45 * ones, 1080.0 * ones), GRAVITY)
points = points_in_camera(body)
tracer = DepthTracer(body.discretisation.surface_triangles, len(points), CAMERA)
ramp = np.linspace(0.0, 2.0, CAMERA.width)
weights = np.tile(ramp, (CAMERA.height, 1)) / (CAMERA.width * CAMERA.height)


def weighted_mean(image: FloatArray, trace: Trace) -> float:
    """Return the weighted mean over the whole image, less that of the background [m]."""
    return float((weights[trace.rows, trace.columns] * (image - BACKGROUND)).sum())


def mean_after(shift: float) -> float:
    """Return the weighted mean with the body shifted to the right [m]."""
    trace = tracer.trace(points + shift * TO_THE_RIGHT)
    return weighted_mean(trace.area_image(side=FINE, background=BACKGROUND).image, trace)


trace = tracer.trace(points)
area = trace.area_image(background=BACKGROUND)
by_vertex = area.pull_back(weights[trace.rows, trace.columns])
gradient = float(pose_gradient(points, by_vertex)[0])
difference = (mean_after(STEP) - mean_after(-STEP)) / (2.0 * STEP)

# Without the outline: only what changes in pixels that see the body before and after.
depth = tracer.trace(points).full_depth()
shifted = tracer.trace(points + STEP * TO_THE_RIGHT).full_depth()
inner = float(np.nansum(weights * (shifted - depth)) / STEP)

print(f'pixels that see the body      {np.isfinite(depth).sum():8d}')
print(f'derivative with the outline   {gradient:8.5f} m/m')
print(f'the same by differences       {difference:8.5f} m/m')
print(f'without the outline           {inner:8.5f} m/m')
