# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The outside of a body and of its fixture as small triangles."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from benchmarks.blind.hexahedra import HexMesh, shape_functions
from benchmarks.blind.paint import IntArray, Paint, painted, PLAIN, Side
from benchmarks.blind.shapes import FloatArray

_CUTS = 3  # Of an element's face along each side; its curve is then followed to a micrometre.


@dataclass(frozen=True)
class Triangles:
    """A surface to be rendered.

    Attributes:
        corners: [m], shape (T, 3, 3).
        labels: ROOT, TIP, FIXTURE, or BETWEEN and more, shape (T,).
    """

    corners: FloatArray
    labels: IntArray


def grid_triangles(cuts: int) -> IntArray:
    """Return triangles over a square grid of (cuts + 1)^2 points, shape (2 cuts^2, 3)."""
    triangles = []
    for row, column in product(range(cuts), repeat=2):
        a = row * (cuts + 1) + column
        b, c, d = a + 1, a + cuts + 1, a + cuts + 2
        triangles += [(a, b, c), (b, d, c)]
    return np.array(triangles)


def body_triangles(
    mesh: HexMesh,
    positions: FloatArray,
    shares: FloatArray,
    paint: Paint = PLAIN,
    heights: FloatArray | None = None,
) -> Triangles:
    """Triangulate a body's surface.

    Args:
        mesh: the body.
        positions: of its nodes, any frame [m], shape (N, 3).
        shares: of the free length at which its nodes rest, shape (N,).
        paint: what is labelled as the tip's.
        heights: of its nodes; what lies at or below 0 is the root's, shape (N,). None: nothing.
    """
    ticks = np.linspace(-1.0, 1.0, _CUTS + 1)
    square = np.stack(np.meshgrid(ticks, ticks, indexing='ij'), axis=-1).reshape(-1, 2)
    triangles = grid_triangles(_CUTS)
    corners, labels = [], []
    for axis, sign in product(range(3), (-1, 1)):
        chosen = (mesh.faces[:, 1] == axis) & (mesh.faces[:, 2] == sign)
        values = shape_functions(np.insert(square, axis, float(sign), axis=1))
        nodes = mesh.cells[mesh.faces[chosen, 0]]
        points = values @ positions[nodes]
        corners.append(points[:, triangles].reshape(-1, 3, 3))
        own = (values, nodes, triangles)
        side = Side(
            along=_middles(shares[:, None], *own)[..., 0],
            points=_middles(mesh.lattice, *own),
            axis=axis,
            sign=sign,
            lattice=mesh.lattice,
            heights=None if heights is None else _middles(heights[:, None], *own)[..., 0],
        )
        labels.append(painted(side, paint).reshape(-1))
    return Triangles(np.concatenate(corners), np.concatenate(labels).astype(np.int64))


def _middles(
    of_nodes: FloatArray, values: FloatArray, nodes: IntArray, triangles: IntArray
) -> FloatArray:
    """Return what nodes have at the middles of small triangles of faces, shape (f, t, c).

    Args:
        of_nodes: shape (N, c).
        values: of the shape functions at points of a face, shape (p, n).
        nodes: of the elements whose faces they are, shape (f, n).
        triangles: of the points, shape (t, 3).
    """
    return np.asarray((values @ of_nodes[nodes])[:, triangles].mean(axis=-2))


def box_triangles(low: FloatArray, high: FloatArray, label: int, cuts: int = 8) -> Triangles:
    """Triangulate a box from its lowest to its highest corner."""
    ticks = np.linspace(0.0, 1.0, cuts + 1)
    square = np.stack(np.meshgrid(ticks, ticks, indexing='ij'), axis=-1).reshape(-1, 2)
    faces = []
    for axis, side in product(range(3), (0.0, 1.0)):
        local = np.insert(square, axis, side, axis=1)
        faces.append((low + local * (high - low))[grid_triangles(cuts)])
    corners = np.concatenate(faces)
    return Triangles(corners, np.full(len(corners), label))


def joined(*parts: Triangles) -> Triangles:
    """Put surfaces together."""
    return Triangles(
        np.concatenate([part.corners for part in parts]),
        np.concatenate([part.labels for part in parts]),
    )


def moved(surface: Triangles, matrix: FloatArray) -> Triangles:
    """Apply a rigid transform, shape (4, 4)."""
    return Triangles(surface.corners @ matrix[:3, :3].T + matrix[:3, 3], surface.labels)
