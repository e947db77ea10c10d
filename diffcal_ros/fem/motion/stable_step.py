# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The longest step that semi-implicit Euler stands.

On a mode of angular frequency w and damping rate c the step h maps (x, v) by a matrix whose
characteristic polynomial is z^2 - (2 - h c - h^2 w^2) z + 1 - h c; both roots stay in the unit
circle while h^2 w^2 + 2 h c < 4.
"""

from collections.abc import Callable

from diffcal_ros.fem.motion.dynamics import Dynamics
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ROUNDS = 60
# The power iteration ends a few per cent low, and a body that is squeezed gets stiffer.
_SAFETY = 0.7


def stable_step(dynamics: Dynamics, positions: FloatArray) -> float:
    """Estimate the step [s] at node positions [m], shape (N, 3), by the highest modes there."""
    still = np.zeros_like(positions)
    stiffness = _largest(
        dynamics, lambda field: dynamics.force_tangent(positions, still, field, still)
    )
    damping = _largest(
        dynamics, lambda field: dynamics.velocity_tangents(positions, still, field[None])[0]
    )
    longest = (np.sqrt(damping**2 + 4.0 * stiffness) - damping) / stiffness
    return _SAFETY * float(longest)


def _largest(dynamics: Dynamics, product: Callable[[FloatArray], FloatArray]) -> float:
    """Return the largest eigenvalue of M^-1 product on the free nodes."""
    free, masses = dynamics.free, dynamics.masses
    field = np.zeros((len(masses), 3))
    field[free] = np.random.default_rng(0).normal(size=(len(free), 3))
    value = 0.0
    for _ in range(_ROUNDS):
        field /= np.sqrt(float((masses * field**2).sum()))
        image = product(field)
        value = float((field * image).sum())
        field[free] = image[free] / masses[free]
        if not field.any():
            break
    return value
