# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rendered depth and its gradient on a full-size image, against its own accuracy."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.ray_reference import trace_rays
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from measuring import cantilevers, timed, write
import numpy as np

CAMERA = PinholeCamera(1024, 768, 739.375, 741.4375, 550.148, 390.645)


def main() -> None:
    """Time the parts and the whole, for one body that covers about 26,000 pixels."""
    mesh = cantilevers()['coarse']
    held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
    body = StaticBody(mesh, Element.LINEAR, held)
    ones = np.ones(mesh.tet_count)
    body.solve_equilibrium(
        Material(60e3 * ones, 0.49 * ones, 1080.0 * ones), np.array([0.0, 9.8, 0.0])
    )
    pose = transform(rotation_matrix(np.array([0.25, -0.2, 0.1])), np.array([0.01, -0.02, 0.44]))
    points = apply(pose, body.state.positions)
    tracer = DepthTracer(body.discretisation.surface_triangles, len(points), CAMERA)
    target = tracer.trace(points + np.array([0.004, -0.003, 0.002])).full_depth()
    target = np.nan_to_num(target)

    def gradient(side: int) -> np.ndarray:
        trace = tracer.trace(points)
        area = trace.area_image(side=side)
        return area.pull_back(2.0 * (area.image - target[trace.rows, trace.columns]))

    exact = gradient(128)
    rows = {}
    for side in (4, 8, 16):
        error = np.linalg.norm(gradient(side) - exact) / np.linalg.norm(exact)
        rows[f'side_{side}'] = {
            **timed(lambda side=side: gradient(side), repeats=100),
            'gradient_error': float(error),
        }
    trace = tracer.trace(points)
    figures = {
        'object_pixels': int((trace.faces >= 0).sum()),
        'outline_pieces': len(trace.outline.lengths),
        'depth_only': timed(lambda: tracer.trace(points).depth, repeats=100),
        'outline': timed(lambda: tracer.trace(points).outline, repeats=100),
        'depth_and_gradient': rows,
        'ray_reference_depth_only': timed(
            lambda: trace_rays(points, body.discretisation.surface_triangles, CAMERA), repeats=5
        ),
    }
    write('depth', figures)


if __name__ == '__main__':
    main()
