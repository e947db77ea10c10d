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


def bent(points: FloatArray, axes: BodyAxes, curvature: FloatArray) -> FloatArray:
    """Bend points of the free part into an arc; sections stay plane and keep their size.

    Args:
        points: at rest [m], shape (N, 3).
        axes: of the body.
        curvature: about the two axes across it [1/m], shape (2,).
    """
    rate = curvature @ axes.axes[1:]
    size = float(np.linalg.norm(rate))
    if size == 0.0:
        return points
    local = points - axes.root
    along = np.maximum(local @ axes.axes[0], 0.0)
    section = local - along[:, None] * axes.axes[0]
    spin = cross_matrix(rate / size)
    angle = size * along
    # The middle line is the integral of the turning tangent, the section turns with it.
    sine, cosine = np.sin(angle)[:, None], np.cos(angle)[:, None]
    tangent = axes.axes[0]
    line = (
        along[:, None] * tangent
        + (1.0 - cosine) / size * (spin @ tangent)
        + (along[:, None] - sine / size) * (spin @ spin @ tangent)
    )
    turned = section + sine * (section @ spin.T) + (1.0 - cosine) * (section @ (spin @ spin).T)
    return axes.root + line + turned


def bent_discretisation(
    mesh: TetMesh, discretisation: Discretisation, axes: BodyAxes, curvature: FloatArray
) -> Discretisation:
    """Return the elements whose shape without stress is the bent mesh."""
    shape = TetMesh(bent(mesh.rest_positions, axes, curvature), mesh.tets)
    return reshaped(discretisation, shape)
