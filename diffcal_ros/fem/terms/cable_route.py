# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a cable runs through a body: points that stay with the material around them."""

from dataclasses import dataclass
from itertools import pairwise

from diffcal_ros.fem.elements.element import Discretisation, Element
from diffcal_ros.tet_mesh import TET_EDGES, TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# A point on a face of the mesh is inside; mesh files of single precision are off by 1e-7.
_SLACK = 1e-6
# Between via points, a cable is looked at this many times for each length of a mean edge.
_LOOKS_AN_EDGE = 8


class RouteError(ValueError):
    """A cable cannot run as it was asked to; the message says what to change."""


@dataclass(frozen=True)
class CableRoute:
    """Via points of a cable, from one end to the other; between them it runs straight.

    Attributes:
        tets: tetrahedron around each via point, shape (n,).
        fractions: its barycentric coordinates there, shape (n, 4).
        length: of the cable through the body at rest [m].
    """

    tets: IntArray
    fractions: FloatArray
    length: float

    def nodes_and_weights(self, discretisation: Discretisation) -> tuple[IntArray, FloatArray]:
        """Return nodes around each via point, shape (n, m), and their shape functions there."""
        nodes, fractions = discretisation.nodes[self.tets], self.fractions
        if discretisation.element is Element.LINEAR:
            return nodes, fractions
        first, second = fractions[:, TET_EDGES[:, 0]], fractions[:, TET_EDGES[:, 1]]
        return nodes, np.hstack([fractions * (2.0 * fractions - 1.0), 4.0 * first * second])


def route_through(
    mesh: TetMesh, via_points: FloatArray, *, may_cross_gaps: bool = False
) -> CableRoute:
    """Find the tetrahedra that a cable runs through.

    Args:
        mesh: the body at rest.
        via_points: in the mesh's frame [m], shape (n, 3), from one end to the other.
        may_cross_gaps: between via points it may hang free, as in a finger's notches.

    Raises:
        RouteError: for fewer than two points, two that coincide, one outside of the body, or a
            cable that leaves it and may not.
    """
    points = np.asarray(via_points, dtype=np.float64)
    if len(points) < 2:
        raise RouteError(
            f'has {len(points)} via points: give at least two, from one end to the other'
        )
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    size = float((mesh.extent[1] - mesh.extent[0]).max())
    if legs.min() < _SLACK * size:
        index = int(legs.argmin())
        raise RouteError(
            f'has via points {index} and {index + 1} at the same place: leave one of them out'
        )
    tets, fractions, depths = _locate(mesh, points)
    outside = np.flatnonzero(depths < -_SLACK)
    if len(outside):
        raise RouteError(
            f'has via point {outside[0]} at {_text(points[outside[0]])}, outside of the body: '
            'move it inside'
        )
    if not may_cross_gaps:
        _require_inside(mesh, points)
    return CableRoute(tets, fractions, float(legs.sum()))


def _require_inside(mesh: TetMesh, points: FloatArray) -> None:
    edges, _ = mesh.edges
    ends = mesh.rest_positions[edges]
    spacing = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean()) / _LOOKS_AN_EDGE
    for index, (start, end) in enumerate(pairwise(points)):
        count = max(int(np.ceil(np.linalg.norm(end - start) / spacing)), 2)
        between = start + np.linspace(0.0, 1.0, count + 1)[1:-1, None] * (end - start)
        _, _, depths = _locate(mesh, between)
        outside = np.flatnonzero(depths < -_SLACK)
        if len(outside):
            raise RouteError(
                f'leaves the body between via points {index} and {index + 1}, at '
                f'{_text(between[outside[0]])}: move them, add one that leads around, or write '
                '`crosses_gaps: true` where it is meant to hang free'
            )


def _locate(mesh: TetMesh, points: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the tetrahedron that holds each point best, its shares, and the smallest of them."""
    corners = mesh.rest_positions[mesh.tets]
    inverse = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
    tets = np.empty(len(points), dtype=np.int32)
    fractions = np.empty((len(points), 4))
    for number, point in enumerate(points):
        last_three = np.einsum('tij,tj->ti', inverse, point - corners[:, 0])
        every = np.hstack([1.0 - last_three.sum(axis=1, keepdims=True), last_three])
        tets[number] = every.min(axis=1).argmax()
        fractions[number] = every[tets[number]]
    return tets, fractions, fractions.min(axis=1)


def _text(point: FloatArray) -> str:
    return '(' + ', '.join(f'{value:.4g}' for value in point) + ') m'
