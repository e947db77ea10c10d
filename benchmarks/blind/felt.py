# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A stack of felt or towels, which hardens as it is pressed, as a penalty in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.shapes import FloatArray

_FOLLOWED = 8.0  # Dent over its length up to which felt is followed; then it is as stiff as there.


def felt(normal: FloatArray, height: float, forces: FloatArray, length: float) -> PotentialLaw:
    """Return a half-space that presses by force (exp(dent / length) - 1).

    Args:
        normal: object frame, shape (3,).
        height: of its upper side along that [m].
        forces: at each node by which its push is stated [N], shape (N,).
        length: dent over which it grows by a factor of e [m].
    """
    outer, most = np.outer(normal, normal), np.exp(_FOLLOWED)

    def penalty(positions: FloatArray) -> Potential:
        dent = np.maximum(height - positions @ normal, 0.0) / length
        part = np.minimum(dent, _FOLLOWED)
        beyond, grown = dent - part, np.exp(part)
        energy = grown - 1.0 - part + (most - 1.0) * beyond + 0.5 * most * beyond**2
        push = grown - 1.0 + most * beyond
        return Potential(
            energy=float((forces * energy).sum()) * length,
            gradient=-(forces * push)[:, None] * normal,
            diagonal=(forces / length * grown * (dent > 0.0))[:, None, None] * outer,
        )

    return penalty
