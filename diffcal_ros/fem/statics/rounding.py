# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much of a force is rounding: no solver can balance forces better than that."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# All elements around a node round, and the worst of many nodes counts: 4 were seen.
_ROUNDINGS = 16.0


def rounding_of_forces(stiffest: float, positions: FloatArray) -> float:
    """Return the force on a node [N] below which a step that does not help shows rounding.

    Positions carry 16 digits, and the stiffest node turns the last one into a force. Of a nearly
    incompressible body of a few MPa that is above any sensible share of its weight.

    Args:
        stiffest: largest entry of the stiffness [N/m].
        positions: of the nodes [m], shape (N, 3).
    """
    last_digit = float(np.finfo(np.float64).eps * np.abs(positions).max())
    return _ROUNDINGS * stiffest * last_digit
