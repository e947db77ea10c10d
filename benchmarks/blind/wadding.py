# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Wadding below a body's outer part: a loose mass of fibres that is pressed together.

Its pressure goes with the third power of how densely it lies, less that of how it lay at first
(van Wyk 1946, J. Textile Inst. 37).
"""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen

_PRESSED = 0.8  # Share of its thickness up to which the law is followed; then it is as stiff.


def wadding_under(
    specimen: Specimen, rest: FloatArray, up: FloatArray, faults: Faults
) -> PotentialLaw:
    """Return a heap of wadding on a level floor below a body's outer part.

    Args:
        specimen: the body.
        rest: where its nodes would rest without it, object frame [m], shape (N, 3).
        up: the world's, object frame, of length 1.
        faults: say how stiff it is, where it begins, and between which levels it lies.
    """
    nodes = specimen.mesh.nodes
    # What is below the middle line comes to lie on it, not the upper side as well.
    is_lower = nodes[:, 1:] @ up[1:] < 0.0
    areas = specimen.areas * is_lower * (specimen.shares >= faults.wool_from)
    heights, lowest = nodes @ up, (rest @ up)[areas > 0.0].min()
    begun = heights[areas > 0.0].min()
    top, floor = (begun + part * (lowest - begun) for part in (faults.wool_top, faults.wool_floor))
    return wadding(faults.wool * areas / areas.sum(), up, float(top), float(top - floor))


def wadding(
    stiffness: FloatArray, normal: FloatArray, top: float, thickness: float
) -> PotentialLaw:
    """Return what presses nodes that are below a level upwards.

    Args:
        stiffness: of each node's share at first [N/m], shape (N,).
        normal: upwards, of length 1, shape (3,).
        top: where it begins, along that [m].
        thickness: from there to the floor [m].
    """
    outer = normal[:, None] * normal

    def energy(positions: FloatArray) -> Potential:
        pressed = np.maximum(top - positions @ normal, 0.0) / thickness
        inside, beyond = np.minimum(pressed, _PRESSED), np.maximum(pressed - _PRESSED, 0.0)
        left = 1.0 - inside
        force = (left**-3 - 1.0) / 3.0
        slope = left**-4 * (pressed > 0.0)
        stored = (0.5 * left**-2 - 0.5 - inside) / 3.0 + beyond * (force + 0.5 * slope * beyond)
        push = stiffness * thickness * (force + slope * beyond)
        return Potential(
            energy=float(thickness**2 * (stiffness @ stored)),
            gradient=-push[:, None] * normal,
            diagonal=(stiffness * slope)[:, None, None] * outer,
        )

    return energy
