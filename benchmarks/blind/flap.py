# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A flap below a body, which turns about its hinge by the moment on it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray


def turned_flap(faults: Faults, turn: float, side: float) -> Faults:
    """Return the plane that a flap is once it has turned.

    Args:
        faults: say where its hinge is along the world's x, and how high.
        turn: by how much it is down at its free end [rad].
        side: 1 where that end is in the direction of the world's x, else -1.
    """
    assert faults.contact_height is not None
    normal = np.array([side * np.sin(turn), np.cos(turn), 0.0])
    hinge = np.array([faults.contact_ahead, faults.contact_height, 0.0])
    return replace(
        faults,
        contact_normal=tuple(float(value) for value in normal),
        contact_height=float(normal @ hinge),
    )


def free_side(observation: Observation, nodes: FloatArray, faults: Faults) -> float:
    """Return on which side of its hinge a flap lies: where the body's tip is, 1 or -1.

    Args:
        observation: the pose.
        nodes: of the body, object frame [m], shape (N, 3).
        faults: say where the hinge is along the world's x.
    """
    tip = applied(observation.world_from_object, nodes[nodes[:, 0].argmax()][None])[0]
    return 1.0 if tip[0] > faults.contact_ahead else -1.0


def hinge_moment(
    observation: Observation, faults: Faults
) -> Callable[[FloatArray, FloatArray], float]:
    """Return the moment by which a body turns a flap down [N m].

    It is told by positions of nodes, object frame [m], and the slopes of the flap's energy there
    [N], shape (N, 3) each. A flap's pushes are square to it, so that their arms are ways from the
    hinge.

    Args:
        observation: the pose.
        faults: say where the hinge is along the world's x, and how high.
    """
    matrix = observation.world_from_object
    hinge = np.array([faults.contact_ahead, faults.contact_height, 0.0])

    def moment(positions: FloatArray, gradient: FloatArray) -> float:
        arms = (applied(matrix, positions) - hinge)[:, :2]
        pushes = np.linalg.norm(gradient, axis=1)
        return float((pushes * np.linalg.norm(arms, axis=1)).sum())

    return moment
