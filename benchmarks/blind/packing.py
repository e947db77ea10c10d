# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A slab of packing foam, whose cells buckle once pressed, as a penalty in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.shapes import FloatArray


def packing(normal: FloatArray, height: float, forces: FloatArray, length: float) -> PotentialLaw:
    """Return a half-space that presses by force (1 - exp(-dent / length)).

    Beyond its first part foam presses as hard however deep it is dented (the plateau of Gibson and
    Ashby 1997, Cellular Solids, ch. 5).

    Args:
        normal: object frame, shape (3,).
        height: of its upper side along that [m].
        forces: at each node to which its push comes up [N], shape (N,).
        length: dent over which two thirds of that are there [m].
    """
    outer = np.outer(normal, normal)

    def penalty(positions: FloatArray) -> Potential:
        dent = np.maximum(height - positions @ normal, 0.0) / length
        lacking = np.exp(-dent)
        return Potential(
            energy=float((forces * (dent - 1.0 + lacking)).sum()) * length,
            gradient=-(forces * (1.0 - lacking))[:, None] * normal,
            diagonal=(forces / length * lacking * (dent > 0.0))[:, None, None] * outer,
        )

    return penalty
