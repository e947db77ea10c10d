# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A groove between two flanks, along the world's x, as a penalty in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray

_FLANK = np.deg2rad(30.0)  # By which each flank rises from the level.


def groove_tops(points: FloatArray, at: float) -> FloatArray:
    """Return how high a groove's bottom may lie before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        at: where its bottom is along the world's z [m].
    """
    return np.asarray(points[:, 1] - np.tan(_FLANK) * np.abs(points[:, 2] - at))


def groove(
    observation: Observation, height: float, at: float, stiffness: FloatArray
) -> PotentialLaw:
    """Return two flanks without friction, each of which presses what lies beyond it back.

    Args:
        observation: the pose.
        height: of the groove's bottom along the world's y [m].
        at: where that is along z [m].
        stiffness: force by dent at each node [N/m], shape (N,).
    """
    turn, shift = observation.world_from_object[:3, :3], observation.world_from_object[:3, 3]
    bottom = turn.T @ (np.array([0.0, height, at]) - shift)
    sides = [np.array([0.0, np.cos(_FLANK), way * np.sin(_FLANK)]) for way in (-1.0, 1.0)]
    normals = np.array(sides) @ turn
    outer = normals[:, :, None] * normals[:, None, :]

    def penalty(positions: FloatArray) -> Potential:
        depth = np.maximum((bottom - positions) @ normals.T, 0.0)
        push = stiffness[:, None] * depth
        touched = stiffness[:, None] * (depth > 0.0)
        return Potential(
            energy=0.5 * float((push * depth).sum()),
            gradient=-push @ normals,
            diagonal=np.einsum('nf,fij->nij', touched, outer),
        )

    return penalty
