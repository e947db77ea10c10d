# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A jaw on a thin bracket of sheet metal, which turns about its bend as a spring, at once.

The bracket has no mass to speak of: at each moment it has the turn at which its own spring and the
jaw's pads bear the same moment. What a body feels has an energy, the least over all turns.
"""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.shapes import FloatArray

TIGHT = 1000.0  # How many times as much the bracket turns as a rigid body in the jaw's pads.
_ROUNDS, _EXACT = 30, 1e-15  # [rad].


def bracket(
    places: FloatArray, stiffness: FloatArray, foot: FloatArray, by_turn: float
) -> PotentialLaw:
    """Return what draws nodes to places that turn about a line along the object's y.

    Args:
        places: of all nodes while the bracket bears nothing [m], shape (N, 3).
        stiffness: of the pads at each node [N/m], shape (N,).
        foot: a point of the line [m], shape (3,).
        by_turn: turn of the bracket by the moment on it [rad/(N m)].
    """
    arms, diagonal = places - foot, stiffness[:, None, None] * np.eye(3)

    def energy(positions: FloatArray) -> Potential:
        away = positions - foot
        along = float(stiffness @ (away[:, ::2] * arms[:, ::2]).sum(axis=1))
        across = float(stiffness @ (away[:, 0] * arms[:, 2] - away[:, 2] * arms[:, 0]))
        turn, slope = turn_of(along, across, by_turn)
        off = away - turned(arms, turn)
        # As the bracket turns on, the nodes go with it: along that way pads bear next to nothing.
        shared = stiffness[:, None] * turned(np.cross([0.0, 1.0, 0.0], arms), turn)
        return Potential(
            energy=0.5 * float(stiffness @ (off**2).sum(axis=1)) + 0.5 * turn**2 / by_turn,
            gradient=stiffness[:, None] * off,
            diagonal=diagonal,
            shared=shared / np.sqrt(slope),
        )

    return energy


def turn_of(along: float, across: float, by_turn: float) -> tuple[float, float]:
    """Return a bracket's turn [rad], and how stiff it is there with its jaw's pads [N m].

    Args:
        along: of the pads: stiffness, place and arm of each, multiplied and summed up [N m].
        across: likewise, by how far the places are a fourth of a turn ahead of the arms [N m].
        by_turn: see `bracket`.
    """
    turn, slope = 0.0, 1.0 / by_turn + along
    for _ in range(_ROUNDS):
        change = (turn / by_turn + along * np.sin(turn) - across * np.cos(turn)) / slope
        turn -= float(change)
        slope = float(1.0 / by_turn + along * np.cos(turn) + across * np.sin(turn))
        if abs(change) < _EXACT:
            break
    return turn, slope


def turned(arms: FloatArray, turn: float) -> FloatArray:
    """Return vectors turned about y [rad], any shape (..., 3)."""
    x, y, z = np.moveaxis(arms, -1, 0)
    cosine, sine = np.cos(turn), np.sin(turn)
    return np.stack([cosine * x + sine * z, y, cosine * z - sine * x], axis=-1)
