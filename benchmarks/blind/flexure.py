# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the end of a leaf spring, or of a post, shifts and turns by force and moment."""

import numpy as np

from benchmarks.blind.shapes import FloatArray

_STEEL = 0.3  # Poisson's ratio of a post.


def flexure_compliance(by_turn: float, length: float) -> FloatArray:
    """Return shift [m] and turn [rad] by force [N] and moment [N m], shape (6, 6).

    The spring lies along the object's x and bends alike about y and z, by Bernoulli's beam; it
    twists as much by a moment about x, and does not grow longer.

    Args:
        by_turn: turn of its end by a moment on that: length over bending stiffness [rad/(N m)].
        length: [m].
    """
    return _end_compliance(by_turn, length, np.array([1.0, 0.0, 0.0]), by_turn)


def post_compliance(by_turn: float, length: float) -> FloatArray:
    """Return the same of a clamp on a round post of steel, which stands along the object's z.

    Its foot is below the clamp, whatever the pose: rig and post are turned together. It twists by
    the moment about z as a round rod does, by 1 + nu as much as it bends.

    Args:
        by_turn: turn of its end by a moment across: length over bending stiffness [rad/(N m)].
        length: from its foot to the clamp [m].
    """
    by_twist = (1.0 + _STEEL) * by_turn
    return _end_compliance(by_turn, length, np.array([0.0, 0.0, 1.0]), by_twist)


def _end_compliance(by_turn: float, length: float, ahead: FloatArray, twist: float) -> FloatArray:
    """Return shift and turn of the end of a beam by force and moment, shape (6, 6).

    Args:
        by_turn: turn of its end by a moment across [rad/(N m)].
        length: [m].
        ahead: direction from its foot to its end, shape (3,).
        twist: turn of its end by a moment along it [rad/(N m)].
    """
    along = np.outer(ahead, ahead)
    turn_by_force = 0.5 * by_turn * length * np.cross(ahead, np.eye(3)).T
    whole = np.empty((6, 6))
    whole[:3, :3] = by_turn * length**2 / 3.0 * (np.eye(3) - along)
    whole[3:, :3] = turn_by_force
    whole[:3, 3:] = turn_by_force.T
    whole[3:, 3:] = by_turn * (np.eye(3) - along) + twist * along
    return whole
