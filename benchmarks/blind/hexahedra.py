# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The 20-node hexahedron with 2x2x2 Gauss points.

Full integration would lock near nu = 0.5; eight points leave one volume constraint per eight
points and 60 numbers, and a row of such elements bends without locking.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.lattice import cut, cut_by_counts, halved, numbered
from benchmarks.blind.other_bodies import OtherShape
from benchmarks.blind.shapes import FloatArray, Shape

IntArray = NDArray[np.int64]

# Local coordinates: of the 27 points of a halved cell those with at most one in the middle.
CORNERS = np.array([p for p in product((-1, 0, 1), repeat=3) if p.count(0) <= 1], dtype=float)
GAUSS = np.array(list(product((-1, 1), repeat=3))) / np.sqrt(3.0)
_GRADING = 1.5
# Six faces: the fixed axis, its side, and the two axes that span it, seen from outside.
_FACES = [(axis, side) for axis in range(3) for side in (-1, 1)]


def shape_functions(local: FloatArray) -> FloatArray:
    """Return the 20 shape functions at local points (..., 3), shape (..., 20)."""
    return np.stack([_function(local, node)[0] for node in CORNERS], axis=-1)


def shape_gradients(local: FloatArray) -> FloatArray:
    """Return their derivatives by the local coordinates, shape (..., 20, 3)."""
    return np.stack([_function(local, node)[1] for node in CORNERS], axis=-2)


def _function(local: FloatArray, node: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Evaluate one shape function and its derivative: a product of four factors."""
    middle = np.flatnonzero(node == 0.0)
    factors = 1.0 + local * node
    slopes = np.broadcast_to(node, local.shape)
    if len(middle):
        axis = middle[0]
        factors = factors.copy()
        slopes = slopes.copy()
        factors[..., axis] = 1.0 - local[..., axis] ** 2
        slopes[..., axis] = -2.0 * local[..., axis]
        scale, last, last_slope = 0.25, np.ones(local.shape[:-1]), np.zeros(3)
    else:
        scale, last, last_slope = 0.125, local @ node - 2.0, node
    whole = scale * factors.prod(axis=-1)
    gradient = np.empty(local.shape)
    for axis in range(3):
        others = np.delete(factors, axis, axis=-1).prod(axis=-1)
        gradient[..., axis] = scale * slopes[..., axis] * others * last + whole * last_slope[axis]
    return whole * last, gradient


@dataclass(frozen=True)
class HexMesh:
    """A body of 20-node hexahedra.

    Attributes:
        lattice: nodes before the shape's map [m], shape (N, 3).
        nodes: at rest, object frame [m], shape (N, 3).
        cells: nodes of each element, in the order of `CORNERS`, shape (C, 20).
        faces: surface faces as (element, local axis, side), shape (F, 3).
        held: nodes in the clamp, ascending.
    """

    lattice: FloatArray
    nodes: FloatArray
    cells: IntArray
    faces: IntArray
    held: IntArray


def mesh_hexahedra(
    shape: Shape, refinement: float = 1.0, held_cells: int = 1, layers: int = 1
) -> HexMesh:
    """Mesh a body.

    Args:
        shape: the body.
        refinement: how many times finer than usual.
        held_cells: number of cells along the held section, one where all of it is held.
        layers: least number of cells over the height.
    """
    if isinstance(shape, OtherShape):
        lattice = cut_by_counts(shape, shape.finer(refinement))
    else:
        width, height = shape.section
        size = (
            0.0062 / refinement,
            min(width / 2.0, 0.0085) / refinement,
            min(min(height / 2.0, 0.0085) / refinement, height / layers),
        )
        lattice = cut(shape, size, held_cells=held_cells, grading=_GRADING)
    local = (CORNERS + 1.0).astype(np.int64)
    triples = 2 * lattice.cells[:, None] + local[None]
    ticks = tuple(halved(axis) for axis in lattice.ticks)
    points, cells = numbered(triples, (ticks[0], ticks[1], ticks[2]))
    return HexMesh(
        lattice=points,
        nodes=shape.place(points),
        cells=cells,
        faces=_outer_faces(lattice.cells),
        held=np.flatnonzero(shape.is_held(points)),
    )


def _outer_faces(cells: IntArray) -> IntArray:
    filled = {tuple(cell) for cell in cells}
    faces = []
    for number, cell in enumerate(cells):
        for axis, side in _FACES:
            beside = cell.copy()
            beside[axis] += side
            if tuple(beside) not in filled:
                faces.append((number, axis, side))
    return np.array(faces, dtype=np.int64)


@dataclass(frozen=True)
class Quadrature:
    """Gauss points of a mesh.

    Attributes:
        gradients: shape-function derivatives by rest coordinates [1/m], shape (C, 8, 20, 3).
        volumes: rest volume of each point [m^3], shape (C, 8).
        values: shape functions at the points, shape (8, 20).
    """

    gradients: FloatArray
    volumes: FloatArray
    values: FloatArray


def integrate(nodes: FloatArray, cells: IntArray) -> Quadrature:
    """Return the quadrature over elements at rest.

    Args:
        nodes: [m], shape (N, 3).
        cells: shape (C, 20).
    """
    local = shape_gradients(GAUSS)
    jacobian = np.einsum('cai,gaj->cgij', nodes[cells], local)
    volumes = np.linalg.det(jacobian)
    if not (volumes > 0.0).all():
        raise ValueError(f'{int((volumes <= 0.0).sum())} Gauss points have no volume')
    gradients = np.einsum('gaj,cgji->cgai', local, np.linalg.inv(jacobian), optimize=True)
    return Quadrature(gradients, volumes, shape_functions(GAUSS))
