# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numerical coarsening: what modulus coarser meshes of one beam need to look like the finest one.

The target is rendered from quadratic elements on the finest mesh; every mesh is fitted to it with
each element, each in a process of its own so that its memory is known.
"""

import argparse
from itertools import permutations

from coarsening_fit import compare
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.material import LameConvention
from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.model import HeldPart, ObservationSetup, Quantity, Region, Scene
from diffcal_ros.synthetic.posed_body import PosedBody
from diffcal_ros.tet_mesh import TetMesh
from measuring import write
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

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


def look(_: PosedBody) -> FloatArray:
    """Return where the camera stands."""
    return DEPTH_FROM_WORLD


def main() -> None:
    """Fit every mesh with each element."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--name', default='coarsening')
    arguments = parser.parse_args()
    scenes = [scene(cells, Element.QUADRATIC, MODULUS) for cells in CELLS]
    write(arguments.name, compare(scenes, CAMERA, look))


if __name__ == '__main__':
    main()
