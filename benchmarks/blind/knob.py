# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is round below a body, as a penalty in the object frame, and a screw with a round end."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

KNOB = 0.015  # Radius of the round end of a screw [m].


def knob_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high a knob may reach before it touches each node [m], shape (N,).

    Args:
        points: object frame [m], shape (N, 3).
        faults: say where the knob is; what is not above it is touched by none.
    """
    ahead, aside = points[:, 0] - faults.contact_ahead, points[:, 1] - faults.contact_at
    squares = KNOB**2 - ahead**2 - aside**2
    return np.where(squares > 0.0, points[:, 2] + KNOB - np.sqrt(np.maximum(squares, 0.0)), np.inf)


def knob(faults: Faults, stiffness: FloatArray) -> PotentialLaw:
    """Return the round end of a screw that goes with the rig, without friction.

    Args:
        faults: say where its top is, object frame [m].
        stiffness: force by dent at each node [N/m], shape (N,).
    """
    assert faults.contact_height is not None
    middle = np.array([faults.contact_ahead, faults.contact_at, faults.contact_height - KNOB])
    return rounded(middle, np.eye(3), KNOB, stiffness)


def rounded(
    middle: FloatArray,
    across: FloatArray,
    radius: float,
    stiffness: FloatArray,
    power: int = 1,
) -> PotentialLaw:
    """Return what is round across some directions.

    Args:
        middle: a point of its axis, or that of a ball, object frame [m], shape (3,).
        across: projection to the directions in which it is round, shape (3, 3).
        radius: [m].
        stiffness: force at each node by a power of the dent [N/m^power], shape (N,).
        power: 1 of what is hard, 2 of foam.
    """

    def penalty(positions: FloatArray) -> Potential:
        away = (positions - middle) @ across
        distance = np.maximum(np.linalg.norm(away, axis=1), 1e-9)
        outward = away / distance[:, None]
        depth = np.maximum(radius - distance, 0.0)
        push = stiffness * depth**power
        slope = power * stiffness * depth ** (power - 1) * (depth > 0.0)
        straight = outward[:, :, None] * outward[:, None, :]
        round_it = across - straight
        return Potential(
            energy=float((push * depth).sum()) / (power + 1),
            gradient=-push[:, None] * outward,
            diagonal=slope[:, None, None] * straight - (push / distance)[:, None, None] * round_it,
        )

    return penalty
