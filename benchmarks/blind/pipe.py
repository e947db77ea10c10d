# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A piece of pipe along the world's x below a body, as a penalty in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.knob import rounded
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray


def pipe_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high a pipe may reach before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        faults: say where its axis is along z, and its radius; what is beside it touches nothing.
    """
    squares = faults.contact_round**2 - (points[:, 2] - faults.contact_at) ** 2
    below = faults.contact_round - np.sqrt(np.maximum(squares, 0.0))
    return np.where(squares > 0.0, points[:, 1] + below, np.inf)


def pipe(observation: Observation, faults: Faults, stiffness: FloatArray) -> PotentialLaw:
    """Return a pipe without friction.

    Args:
        observation: the pose.
        faults: say how high it reaches along the world's y, where it is along z, and its radius.
        stiffness: force by dent at each node [N/m], shape (N,).
    """
    assert faults.contact_height is not None
    radius, matrix = faults.contact_round, observation.world_from_object
    turn, shift = matrix[:3, :3], matrix[:3, 3]
    middle = np.array([0.0, faults.contact_height - radius, faults.contact_at])
    across = np.eye(3) - np.outer(turn[0], turn[0])
    return rounded(turn.T @ (middle - shift), across, radius, stiffness)
