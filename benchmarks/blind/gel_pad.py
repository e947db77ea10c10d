# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pad of gel, which hardens by the cube of how deep it is dented, in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.shapes import FloatArray


def gel_pad(normal: FloatArray, height: float, forces: FloatArray, length: float) -> PotentialLaw:
    """Return a half-space that presses by force (dent / length + (dent / length)^3).

    Args:
        normal: object frame, shape (3,).
        height: of its upper side along that [m].
        forces: at each node, half of its push where the dent is the length [N], shape (N,).
        length: dent from which on the cube is more than what goes evenly [m].
    """
    outer = np.outer(normal, normal)

    def penalty(positions: FloatArray) -> Potential:
        dent = np.maximum(height - positions @ normal, 0.0) / length
        stiff = forces / length * (1.0 + 3.0 * dent**2) * (dent > 0.0)
        return Potential(
            energy=float((forces * (0.5 * dent**2 + 0.25 * dent**4)).sum()) * length,
            gradient=-(forces * (dent + dent**3))[:, None] * normal,
            diagonal=stiff[:, None, None] * outer,
        )

    return penalty
