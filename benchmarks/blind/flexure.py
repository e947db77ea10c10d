# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the end of a leaf spring shifts and turns by force and moment."""

import numpy as np

from benchmarks.blind.shapes import FloatArray


def flexure_compliance(by_turn: float, length: float) -> FloatArray:
    """Return shift [m] and turn [rad] by force [N] and moment [N m], shape (6, 6).

    The spring lies along the object's x and bends alike about y and z, by Bernoulli's beam; it
    twists as much by a moment about x, and does not grow longer.

    Args:
        by_turn: turn of its end by a moment on that: length over bending stiffness [rad/(N m)].
        length: [m].
    """
    ahead = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    across = np.diag([0.0, 1.0, 1.0])
    turn_by_force = 0.5 * by_turn * length * ahead
    whole = np.empty((6, 6))
    whole[:3, :3] = by_turn * length**2 / 3.0 * across
    whole[3:, :3] = turn_by_force
    whole[:3, 3:] = turn_by_force.T
    whole[3:, 3:] = by_turn * np.eye(3)
    return whole
