# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A table whose holes blow air, on which a body hovers, as a penalty in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.shapes import FloatArray

_FOLLOWED = 4.0  # Lengths below its height down to which air is followed; then it is as stiff.


def air_table(
    normal: FloatArray, height: float, forces: FloatArray, length: float
) -> PotentialLaw:
    """Return a half-space that presses by force exp((height - place) / length), near or far.

    Args:
        normal: object frame, shape (3,).
        height: along that, where its push is as stated [m].
        forces: at each node, there [N], shape (N,).
        length: way up over which it falls to a third [m].
    """
    outer, most = np.outer(normal, normal), np.exp(_FOLLOWED)

    def penalty(positions: FloatArray) -> Potential:
        deep = (height - positions @ normal) / length
        part = np.minimum(deep, _FOLLOWED)
        beyond, grown = deep - part, np.exp(part)
        return Potential(
            energy=float((forces * (grown + most * (beyond + 0.5 * beyond**2))).sum()) * length,
            gradient=-(forces * (grown + most * beyond))[:, None] * normal,
            diagonal=(forces / length * grown)[:, None, None] * outer,
        )

    return penalty
