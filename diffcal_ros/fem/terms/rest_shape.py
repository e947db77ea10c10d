# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A shape without stress that is bent against the mesh."""

from diffcal_ros.fem.body_axes import BodyAxes
from diffcal_ros.fem.elements.element import Discretisation, reshaped
from diffcal_ros.rigid_transform import cross_matrix
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def bent(points: FloatArray, axes: BodyAxes, rates: FloatArray) -> FloatArray:
    """Bend and twist points of the free part; sections stay plane and keep their size.

    The middle line is the integral of a tangent that turns along it, and the sections turn with
    it: in each part an arc, or a helix where it is twisted.

    Args:
        points: at rest [m], shape (N, 3).
        axes: of the body; one that is bent already is bent on, along its line.
        rates: twist and curvatures about the two axes across the body [1/m], in each of as many
            equal parts of the free length, shape (s, 3).
    """
    if not rates.any():
        return points
    if axes.line is not None:
        return axes.root + axes.line.bent(axes.own(points), rates) @ axes.axes
    local = points - axes.root
    along = np.maximum(local @ axes.axes[0], 0.0)
    section = local - along[:, None] * axes.axes[0]
    length = axes.length / len(rates)
    part = np.minimum((along / length).astype(int), len(rates) - 1)
    found = np.empty_like(points)
    line, turn = axes.root, np.eye(3)
    for number, rate in enumerate(rates @ axes.axes):
        own = part == number
        moved, turned = _helix(along[own] - number * length, axes.axes[0], rate)
        found[own] = line + (moved + np.einsum('nij,nj->ni', turned, section[own])) @ turn.T
        (moved,), (turned,) = _helix(np.array([length]), axes.axes[0], rate)
        line, turn = line + turn @ moved, turn @ turned
    return found


def _helix(
    along: FloatArray, tangent: FloatArray, rate: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where a line goes that turns at an even rate, and how it has turned there.

    Args:
        along: lengths of it [m], shape (n,).
        tangent: where it begins, unit vector, shape (3,).
        rate: about which it turns [1/m], shape (3,); it turns along.

    Returns:
        Shapes (n, 3) and (n, 3, 3).
    """
    size = float(np.linalg.norm(rate))
    if size == 0.0:
        return along[:, None] * tangent, np.tile(np.eye(3), (len(along), 1, 1))
    spin = cross_matrix(rate / size)
    sine, cosine = np.sin(size * along)[:, None], np.cos(size * along)[:, None]
    line = (
        along[:, None] * tangent
        + (1.0 - cosine) / size * (spin @ tangent)
        + (along[:, None] - sine / size) * (spin @ spin @ tangent)
    )
    turned = np.eye(3) + sine[..., None] * spin + (1.0 - cosine)[..., None] * (spin @ spin)
    return line, turned


def bent_discretisation(
    mesh: TetMesh, discretisation: Discretisation, axes: BodyAxes, rates: FloatArray
) -> Discretisation:
    """Return the elements whose shape without stress is the bent mesh; rates as by `bent`."""
    shape = TetMesh(bent(mesh.rest_positions, axes, rates), mesh.tets)
    return reshaped(discretisation, shape)
