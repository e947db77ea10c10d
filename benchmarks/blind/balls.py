# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rubber balls that lie side by side below a body's outer part, which swings down on them.

Each presses back by the power of one and a half of how far it is flattened (Hertz 1881, J. reine
angew. Math. 92).
"""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen


def balls_under(
    specimen: Specimen, rest: FloatArray, up: FloatArray, faults: Faults
) -> PotentialLaw:
    """Return balls whose tops are level below a body's outer part.

    Args:
        specimen: the body.
        rest: where its nodes would rest without them, object frame [m], shape (N, 3).
        up: the world's, object frame, of length 1.
        faults: say how stiff they are, where the first lies, and how high they reach.
    """
    nodes = specimen.mesh.nodes
    # Its lower side comes to lie on them, not the upper one as well.
    is_lower = nodes[:, 1:] @ up[1:] < 0.0
    areas = specimen.areas * is_lower * (specimen.shares >= faults.balls_from)
    begun = float((nodes @ up)[areas > 0.0].min())
    lowest = float((rest @ up)[areas > 0.0].min())
    top = begun + faults.balls_top * (lowest - begun)
    return balls(faults.balls * areas / areas.sum(), up, top)


def balls(stiffness: FloatArray, normal: FloatArray, top: float) -> PotentialLaw:
    """Return what presses nodes that are below a level upwards.

    Args:
        stiffness: force at each node by the power of one and a half [N/m^1.5], shape (N,).
        normal: upwards, of length 1, shape (3,).
        top: how high balls reach along that [m].
    """
    outer = normal[:, None] * normal

    def energy(positions: FloatArray) -> Potential:
        flattened = np.maximum(top - positions @ normal, 0.0)
        root = np.sqrt(flattened)
        return Potential(
            energy=0.4 * float(stiffness @ (root * flattened**2)),
            gradient=-(stiffness * root * flattened)[:, None] * normal,
            diagonal=(1.5 * stiffness * root)[:, None, None] * outer,
        )

    return energy
