# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Drag of still air on a moving body, in proportion to the square of its speed.

Every part of the free surface with the share s of its area feels the force

    -1/2 rho s C_d A |v| v

so that a body that moves as one feels that of drag coefficient C_d and area A.
"""

from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.terms.potential_terms import surface_areas
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

AIR_DENSITY = 1.2  # At 20 degrees and sea level [kg/m^3].


class AirDrag:
    """Drag on one body; velocities [m/s] and forces [N] have shape (N, 3)."""

    def __init__(self, discretisation: Discretisation, free_nodes: NDArray[np.int32]) -> None:
        """Prepare the shares of the free surface.

        Args:
            discretisation: whose surface meets the air.
            free_nodes: those that are not held; others feel no drag.
        """
        areas = np.zeros(discretisation.node_count)
        areas[free_nodes] = surface_areas(discretisation)[free_nodes]
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
        return self._unit * _speeds(velocities) * velocities

    def tangent(self, velocities: FloatArray, sped: FloatArray) -> FloatArray:
        """Return how the forces follow a change of velocities; the matrix is symmetric."""
        speeds = _speeds(velocities)
        along = (velocities * sped).sum(axis=1, keepdims=True)
        turned = np.divide(velocities * along, speeds, where=speeds > 0.0, out=np.zeros_like(sped))
        return self._area * self._unit * (speeds * sped + turned)


def _speeds(velocities: FloatArray) -> FloatArray:
    """Return the length of each velocity, shape (N, 1)."""
    return np.asarray(np.linalg.norm(velocities, axis=1, keepdims=True))
