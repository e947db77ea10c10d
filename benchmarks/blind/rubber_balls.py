# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A tray of rubber balls, which press by the power 3/2 of a dent, in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.shapes import FloatArray


def rubber_balls(
    normal: FloatArray, height: float, forces: FloatArray, length: float
) -> PotentialLaw:
    """Return a half-space that presses by force (dent / length)^(3/2) (Hertz 1881).

    Args:
        normal: object frame, shape (3,).
        height: of the balls' tops along that [m].
        forces: at each node, its push where the dent is the length [N], shape (N,).
        length: of that dent [m].
    """
    outer = np.outer(normal, normal)

    def penalty(positions: FloatArray) -> Potential:
        dent = np.maximum(height - positions @ normal, 0.0) / length
        stiff = 1.5 * forces / length * np.sqrt(dent)
        return Potential(
            energy=0.4 * length * float((forces * dent**2.5).sum()),
            gradient=-(forces * dent**1.5)[:, None] * normal,
            diagonal=stiff[:, None, None] * outer,
        )

    return penalty
