# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Equilibria, gradients and rendered depth on a GPU beside the processor: seconds and agreement.

Where there is no GPU nothing is run, and no file is written.
"""

import argparse
from typing import Any

from depth import CAMERA
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.device_array import device_names
from diffcal_ros.fem.element import Element
from diffcal_ros.fem.static_body import StaticBody
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.tet_mesh import TetMesh
from equilibrium import GRAVITY, uniform_material
from measuring import cantilevers, timed, write
import numpy as np

POSE = transform(rotation_matrix(np.array([0.25, -0.2, 0.1])), np.array([0.01, -0.02, 0.44]))


def measure(mesh: TetMesh, device: str, repeats: int) -> tuple[dict[str, Any], np.ndarray]:
    """Time one body on one device; return the figures and where it comes to rest [m], (N, 3)."""
    held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
    body = StaticBody(mesh, Element.QUADRATIC, held, device=device)
    material = uniform_material(mesh.tet_count)

    def settle() -> None:
        body.forget()
        body.solve_equilibrium(material, GRAVITY)
        body.gradient(np.ones_like(body.state.positions))

    figures = {'cold': timed(settle, repeats=repeats)}
    rest = body.discretisation.rest_nodes
    figures['stiffness_product'] = timed(
        lambda: body.elastic.force_tangent(rest, rest), repeats=10 * repeats
    )
    points = apply(POSE, body.state.positions)
    tracer = DepthTracer(body.discretisation.surface_triangles, len(points), CAMERA, device=device)

    def render() -> None:
        area = tracer.trace(points).area_image(side=8)
        area.pull_back(area.image)

    figures['depth_and_gradient'] = timed(render, repeats=10 * repeats)
    return figures, body.state.positions


def main() -> None:
    """Run every mesh on the processor and on the GPU."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--device', default='cuda:0')
    parser.add_argument('--repeats', type=int, default=5)
    parser.add_argument('--name', default='gpu')
    arguments = parser.parse_args()
    if arguments.device not in device_names():
        raise SystemExit(
            f'NOTHING WAS RUN: this machine has no {arguments.device}, but '
            f'{", ".join(device_names())}; no file was written'
        )
    rows = {}
    for name, mesh in cantilevers().items():
        here, expected = measure(mesh, 'cpu', arguments.repeats)
        there, found = measure(mesh, arguments.device, arguments.repeats)
        rows[name] = {
            'tets': mesh.tet_count,
            'cpu': here,
            arguments.device: there,
            'times_as_fast': {key: here[key]['median_s'] / there[key]['median_s'] for key in here},
            'largest_difference_m': float(np.abs(found - expected).max()),
        }
        write(arguments.name, {'device': arguments.device, 'rows': rows})


if __name__ == '__main__':
    main()
