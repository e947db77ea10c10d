# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body that every package gets: a cantilever, its material, its motion and its view.

Importable without a measurement; the main process writes it to a file that all others read.
"""

from pathlib import Path
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.motion.inputs import Release
from diffcal_ros.fem.statics.force_changes import Change, gravity_loads
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.tet_mesh import TetMesh
import numpy as np

from benchmarks.measuring import cantilevers

GRAVITY = np.array([0.0, 9.8, 0.0])
MODULUS, POISSON, DENSITY = 200e3, 0.45, 1080.0
CAMERA = PinholeCamera(1024, 768, 739.375, 741.4375, 550.148, 390.645)
DURATION = 0.4
_POSE = transform(rotation_matrix(np.array([0.25, -0.2, 0.1])), np.array([0.01, -0.02, 0.44]))
# The picture that depth is compared with is of the body moved by so much [m].
_SHIFT = np.array([0.004, -0.003, 0.002])


def material(count: int, modulus: float = MODULUS, **options: Any) -> Material:
    """Return one uniform material for so many tetrahedra."""
    ones = np.ones(count)
    return Material(modulus * ones, POISSON * ones, DENSITY * ones, **options)


def held_vertices(mesh: TetMesh) -> Any:
    """Return the clamped vertices, shape (h,)."""
    return np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)


def release(mesh: TetMesh) -> Release:
    """Return the ledge under the free end, taken away at t = 0."""
    ends = np.flatnonzero(mesh.rest_positions[:, 0] <= -0.09 + 1e-9).astype(np.int32)
    return Release(ends, 0.0)


def write_case(path: Path) -> None:
    """Write everything that a package may need, SI units."""
    mesh = cantilevers()['coarse']
    held = held_vertices(mesh)
    constants = material(mesh.tet_count).lame_parameters()
    values = {
        'positions': mesh.rest_positions,
        'tets': mesh.tets.astype(np.int64),
        'held': held,
        'tip': int(np.argmin(mesh.rest_positions[:, 0])),
        'modulus': MODULUS,
        'poisson': POISSON,
        'density': DENSITY,
        'gravity': float(GRAVITY[1]),
        'law_mu': float(constants.neo_hookean_mu[0]),
        'law_lambda': float(constants.neo_hookean_lambda[0]),
        'duration': DURATION,
        **_quadratic(mesh, held),
        **_start(mesh),
        **_view(mesh, held),
    }
    values['loads'] = gravity_loads(
        discretise(mesh, Element.LINEAR), np.full(mesh.tet_count, DENSITY), GRAVITY
    )
    np.savez(path, **values)


def _quadratic(mesh: TetMesh, held: Any) -> dict[str, Any]:
    """Return the ten-node mesh; its nodes are in VTK's order."""
    body = StaticBody(mesh, Element.QUADRATIC, held)
    cut = body.discretisation
    return {
        'nodes10': cut.rest_nodes,
        'tets10': cut.nodes.astype(np.int64),
        'held10': body.held_nodes,
        'loads10': gravity_loads(cut, np.full(mesh.tet_count, DENSITY), GRAVITY),
    }


def _start(mesh: TetMesh) -> dict[str, Any]:
    """Return where the motion begins, at rest on clamp and ledge, and how that follows log E."""
    ledge = release(mesh).supported_vertices
    body = StaticBody(mesh, Element.LINEAR, np.union1d(held_vertices(mesh), ledge))
    solid = material(mesh.tet_count)
    start = body.solve_equilibrium(solid, GRAVITY).positions
    by_modulus = body.tangents([Change(youngs_modulus=solid.youngs_modulus)])[0]
    return {'start': start, 'start_by_log_modulus': by_modulus}


def _view(mesh: TetMesh, held: Any) -> dict[str, Any]:
    """Return the hanging body before a camera, in the camera frame."""
    body = StaticBody(mesh, Element.LINEAR, held)
    # As in benchmarks/depth.py: so soft a body covers about 26,000 pixels.
    soft = Material(*(np.full(mesh.tet_count, value) for value in (60e3, 0.49, DENSITY)))
    body.solve_equilibrium(soft, GRAVITY)
    points = apply(_POSE, body.state.positions)
    triangles = body.discretisation.surface_triangles
    tracer = DepthTracer(triangles, len(points), CAMERA)
    here, there = tracer.trace(points), tracer.trace(points + _SHIFT)
    target = np.nan_to_num(there.in_image(there.area_image(side=16).image))
    # Rows and columns where either body is seen: left, top, right, bottom.
    seen = np.argwhere((target > 0.0) | np.isfinite(here.full_depth()))
    (top, left), (bottom, right) = seen.min(axis=0) - 1, seen.max(axis=0) + 2
    return {
        'points': points,
        'object_pixels': int((here.faces >= 0).sum()),
        'window': np.array([left, top, right, bottom]),
        'target': target[top:bottom, left:right],
        'triangles': triangles,
        'camera': np.array([CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy]),
        'image_size': np.array([CAMERA.width, CAMERA.height]),
    }
