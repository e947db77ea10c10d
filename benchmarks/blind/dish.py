# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A round dish, which rises with the square of the way, as a penalty in the object frame.

With a radius below 0 it falls as a cushion does, whose bottom is its top.
"""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray

_LEVEL = np.array([1.0, 0.0, 1.0])


def dish_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high a dish's bottom may lie before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        faults: say where its bottom is, and how round.
    """
    ahead, aside = points[:, 0] - faults.contact_ahead, points[:, 2] - faults.contact_at
    return np.asarray(points[:, 1] - 0.5 * (ahead**2 + aside**2) / faults.contact_round)


def dish(observation: Observation, faults: Faults, stiffness: FloatArray) -> PotentialLaw:
    """Return a dish without friction.

    Args:
        observation: the pose.
        faults: say where its bottom is, and how round.
        stiffness: force by dent at each node [N/m], shape (N,).
    """
    assert faults.contact_height is not None
    height, matrix = faults.contact_height, observation.world_from_object
    turn, shift = matrix[:3, :3], matrix[:3, 3]
    bottom = np.array([faults.contact_ahead, 0.0, faults.contact_at])
    round_it = turn.T @ np.diag(_LEVEL) @ turn / faults.contact_round

    def penalty(positions: FloatArray) -> Potential:
        points = positions @ turn.T + shift
        dent = np.maximum(height - dish_tops(points, faults), 0.0)
        slope = (points - bottom) * _LEVEL / faults.contact_round - np.array([0.0, 1.0, 0.0])
        slope = slope @ turn
        push, touched = stiffness * dent, stiffness * (dent > 0.0)
        outer = slope[:, :, None] * slope[:, None, :]
        return Potential(
            energy=0.5 * float((push * dent).sum()),
            gradient=push[:, None] * slope,
            diagonal=touched[:, None, None] * outer + push[:, None, None] * round_it,
        )

    return penalty
