# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A bed of bristles, which bend over and then press no more, as a penalty in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.shapes import FloatArray


def brush(normal: FloatArray, height: float, forces: FloatArray, bend: float) -> PotentialLaw:
    """Return a half-space that presses by force (1 - exp(-dent / bend)).

    Args:
        normal: object frame, shape (3,).
        height: of the bristles' ends along that [m].
        forces: of the bristles below each node, once they are bent over [N], shape (N,).
        bend: dent at which two thirds of them are [m].
    """
    outer = np.outer(normal, normal)

    def penalty(positions: FloatArray) -> Potential:
        dent = np.maximum(height - positions @ normal, 0.0)
        bent = -np.expm1(-dent / bend)
        return Potential(
            energy=float((forces * (dent - bend * bent)).sum()),
            gradient=-(forces * bent)[:, None] * normal,
            diagonal=(forces / bend * (1.0 - bent) * (dent > 0.0))[:, None, None] * outer,
        )

    return penalty
