# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A diagonal mass matrix that keeps every element's mass positive at all its nodes."""

from diffcal_ros.fem.elements.element import Discretisation, Element
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Diagonal of the 10-node tetrahedron's consistent mass, scaled to the element's mass (Hinton, Rock
# and Zienkiewicz 1976): row sums would be negative at corners.
_CORNER, _MIDDLE = 1.0 / 36.0, 4.0 / 27.0


def lumped_fractions(discretisation: Discretisation) -> FloatArray:
    """Return the share of each tetrahedron's volume at its nodes [m^3], shape (T, n)."""
    volumes = discretisation.weights.sum(axis=1)
    if discretisation.element is Element.LINEAR:
        return np.repeat(volumes[:, None] / 4.0, 4, axis=1)
    return volumes[:, None] * np.repeat([_CORNER, _MIDDLE], [4, 6])


def lumped_masses(
    discretisation: Discretisation, fractions: FloatArray, density: FloatArray
) -> FloatArray:
    """Return nodal masses [kg], shape (N,), of a density per tetrahedron [kg/m^3]."""
    masses: FloatArray = np.bincount(
        discretisation.nodes.ravel(),
        weights=(fractions * density[:, None]).ravel(),
        minlength=discretisation.node_count,
    ).astype(np.float64)
    return masses
