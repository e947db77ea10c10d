# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Drag of still air on a moving body, in proportion to the square of its speed.

Every part of the free surface with the share s of its area feels the force

    -1/2 rho s C_d A |v| v

so that a surface that moves as one feels that of drag coefficient C_d and area A. The force is
integrated over the surface: shared among nodes, a coarse mesh has some percent too much or too
little of it, since speeds grow towards the tip and what the clamp's nodes get is lost.
"""

from diffcal_ros.fem.elements.element import Discretisation
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

FloatArray = NDArray[np.float64]

AIR_DENSITY = 1.2  # At 20 degrees and sea level [kg/m^3].

# Three points of a triangle, exact for quadratic integrands (Hammer, Marlowe and Stroud 1956).
_POINTS = np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3)


class AirDrag:
    """Drag on one body; velocities [m/s] and forces [N] have shape (N, 3).

    Held nodes that border on the free surface have forces, too: their support bears them.
    """

    def __init__(self, discretisation: Discretisation, free_nodes: NDArray[np.int32]) -> None:
        """Prepare points of the free surface.

        Args:
            discretisation: whose surface meets the air.
            free_nodes: those that are not held; a triangle of held nodes alone meets no air.
        """
        triangles = discretisation.surface_triangles
        triangles = triangles[np.isin(triangles, free_nodes).any(axis=1)]
        corners = discretisation.rest_nodes[triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = np.repeat(np.linalg.norm(normals, axis=1), len(_POINTS))
        columns = np.repeat(triangles, len(_POINTS), axis=0)
        rows = np.repeat(np.arange(len(columns)), 3)
        shape = (len(columns), discretisation.node_count)
        values = np.tile(_POINTS, (len(triangles), 1))
        self._to_points = csr_array((values.ravel(), (rows, columns.ravel())), shape=shape)
        self._to_nodes = csr_array(self._to_points.T)
        self._unit = (0.5 * AIR_DENSITY / areas.sum()) * areas[:, None]
        self._area = 0.0

    @property
    def is_present(self) -> bool:
        """Tell whether there is any drag."""
        return self._area != 0.0

    def set_area(self, area: float) -> None:
        """Set drag coefficient times area [m^2]."""
        self._area = area

    def forces(self, velocities: FloatArray) -> FloatArray:
        """Return the drag on the side of elastic forces: along the velocity."""
        return self._area * self.force_of_area(velocities)

    def force_of_area(self, velocities: FloatArray) -> FloatArray:
        """Return the derivative of the forces by the area [N/m^2], shape (N, 3)."""
        there = self._to_points @ velocities
        return np.asarray(self._to_nodes @ (self._unit * _speeds(there) * there))

    def tangent(self, velocities: FloatArray, sped: FloatArray) -> FloatArray:
        """Return how the forces follow a change of velocities; the matrix is symmetric."""
        return self.tangents(velocities, sped[None])[0]

    def tangents(self, velocities: FloatArray, sped: FloatArray) -> FloatArray:
        """Return how the forces follow each change of velocities [m/s], shape (k, N, 3)."""
        there = self._to_points @ velocities
        speeds = _speeds(there)
        directions = np.divide(there, speeds, where=speeds > 0.0, out=np.zeros_like(there))
        # Nodes first, so that one product serves all changes.
        changes = self._to_points @ sped.transpose(1, 2, 0).reshape(len(velocities), -1)
        changes = changes.reshape(len(there), 3, len(sped))
        along = (there[:, :, None] * changes).sum(axis=1, keepdims=True)
        felt = speeds[:, :, None] * changes + directions[:, :, None] * along
        felt *= self._unit[:, :, None]
        forces = self._to_nodes @ felt.reshape(len(there), -1)
        return self._area * forces.reshape(len(velocities), 3, len(sped)).transpose(2, 0, 1)


def _speeds(velocities: FloatArray) -> FloatArray:
    """Return the length of each velocity, shape (n, 1)."""
    return np.asarray(np.linalg.norm(velocities, axis=1, keepdims=True))
