# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numerical coarsening: what modulus coarser meshes of one beam need to look like the finest one.

The target is rendered from quadratic elements on the finest mesh; every mesh is fitted to it with
each element, each in a process of its own so that its memory is known.
"""

import argparse
from itertools import permutations
from multiprocessing import get_context
import resource
import time
from typing import Any

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.observation import Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.element import Element
from diffcal_ros.material import LameConvention
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.model import HeldPart, ObservationSetup, Quantity, Region, Scene
from diffcal_ros.synthetic.posed_body import pose_body
from diffcal_ros.tet_mesh import TetMesh
from measuring import write
import numpy as np

# 18,000 to 960 tetrahedra, six in each cell; every mesh has a face where the clamp ends.
CELLS = ((30, 10, 10), (20, 7, 7), (15, 5, 5), (10, 4, 4))
SIZE = np.array([0.16, 0.036, 0.03])
MODULUS, RATIO, DENSITY = 130e3, 0.49, 1080.0
CAMERA = PinholeCamera(640, 480, 460.0, 463.0, 322.5, 236.25)
DEPTH_FROM_WORLD = transform(
    rotation_matrix(np.array([np.pi - 0.25, 0.2, 0.1])), np.array([-0.09, -0.01, 0.30])
)


def beam(cells: tuple[int, int, int]) -> TetMesh:
    """Cut the beam into cells and each of them into six tetrahedra."""
    counts = np.array(cells) + 1
    grid = np.stack(np.meshgrid(*map(np.arange, counts), indexing='ij'), axis=-1).reshape(-1, 3)
    steps = np.array([counts[1] * counts[2], counts[2], 1])
    lows = grid[(grid < np.array(cells)).all(axis=1)] @ steps
    # Each order of the three axes is a path along a cell's edges from corner to far corner.
    paths = [np.cumsum([0, *steps[list(order)]]) for order in permutations(range(3))]
    tets = np.concatenate([lows[:, None] + path for path in paths])
    positions = grid / np.array(cells) * SIZE
    corners = positions[tets]
    turned = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    tets[turned] = tets[turned][:, [0, 1, 3, 2]]
    return TetMesh(positions, tets.astype(np.int32))


def scene(cells: tuple[int, int, int], element: Element, start: float) -> Scene:
    """Hang the beam by its low end."""
    mesh = beam(cells)
    held = np.flatnonzero(mesh.rest_positions[:, 0] < 0.2 * SIZE[0] + 1e-9).astype(np.int32)
    region = Region(
        name='beam',
        tets=np.arange(mesh.tet_count, dtype=np.int32),
        youngs_modulus=Quantity(start, 5e3, 5e6),
        poissons_ratio=Quantity(RATIO, 0.0, 0.499),
        density=Quantity(DENSITY, 100.0, 1e4),
    )
    setup = ObservationSetup(
        'hanging', np.eye(4), np.array([0.0, -9.8, 0.0]), (HeldPart('clamp', held),)
    )
    return Scene(
        name='beam',
        mesh=mesh,
        element=element,
        regions=(region,),
        convention=LameConvention.CONSISTENT,
        observations=(setup,),
        fit=('youngs_modulus',),
    )


def target(cells: tuple[int, int, int]) -> dict[str, Any]:
    """Render the finest mesh, with the noise and the steps of an L515."""
    truth = scene(cells, Element.QUADRATIC, MODULUS)
    begun = time.perf_counter()
    body = pose_body(truth, truth.observations[0])
    seconds = time.perf_counter() - begun
    points = apply(DEPTH_FROM_WORLD, body.positions)
    depth = DepthTracer(body.triangles, len(points), CAMERA).trace(points).full_depth()
    noisy = depth + np.random.default_rng(5).normal(scale=0.00014, size=depth.shape)
    return {
        'depth': (np.round(noisy / 0.00025) * 0.00025).astype(np.float32),
        'largest_sag_mm': 1e3 * body.largest_displacement,
        'cold_s': seconds,
        'peak_mb': _peak(),
    }


def fit(cells: tuple[int, int, int], element: str, depth: Any) -> dict[str, Any]:
    """Fit one mesh with one element."""
    own = scene(cells, Element(element), 1.3 * MODULUS)
    begun = time.perf_counter()
    pose_body(own, own.observations[0])
    cold = time.perf_counter() - begun
    seen = Observation('beam', 0, depth, CAMERA, DEPTH_FROM_WORLD)
    result = calibrate(own, [seen], CalibrationSettings(with_mesh_error=False))
    return {
        'element': element,
        'tets': own.mesh.tet_count,
        'share_of_true_modulus': result['youngs_modulus'].value / MODULUS,
        'gap_median_mm': 1e3 * result.gap_end.median,
        'gap_rms_mm': 1e3 * result.gap_end.rms,
        'outcome': result.outcome.value,
        'iterations': result.iterations,
        'fit_s': result.seconds,
        'cold_s': cold,
        'peak_mb': _peak(),
    }


def _peak() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main() -> None:
    """Fit every mesh with each element."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--name', default='coarsening')
    arguments = parser.parse_args()
    rows, finest = [], CELLS[0]
    with get_context('spawn').Pool(1, maxtasksperchild=1) as pool:
        seen = pool.apply(target, (finest,))
        depth = seen.pop('depth')
        for cells in CELLS:
            for element in Element:
                rows.append(pool.apply(fit, (cells, element.value, depth)))
                print(rows[-1], flush=True)
    shares = {
        element.value: [
            row['share_of_true_modulus'] for row in rows if row['element'] == element.value
        ]
        for element in Element
    }
    spread = {name: max(own) - min(own) for name, own in shares.items()}
    write(
        arguments.name,
        {
            'target': seen,
            'rows': rows,
            'spread': spread,
            'spread_ratio': spread['quadratic'] / spread['linear'],
            'linear_falls_with_coarseness': bool((np.diff(shares['linear']) < 0.0).all()),
        },
    )


if __name__ == '__main__':
    main()
