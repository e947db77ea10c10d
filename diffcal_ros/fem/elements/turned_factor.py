# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A factorisation that is turned along with a body's material.

A slender body is a thousand times stiffer along its axis than across. Once it has turned by a few
degrees an old factorisation takes the one for the other, and conjugate gradients with it hardly
get on. The stiffness turns with the material around each node; so does its inverse then.
"""

from collections.abc import Callable

from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.elements.node_rotations import NodeRotations
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class TurnedFactor:
    """Applies the factorisation of one place at another."""

    def __init__(self, elastic: ElasticBody, free_nodes: NDArray[np.integer]) -> None:
        """Prepare for a body whose free nodes are the unknowns, shape (M,).

        The stiffness of a law that takes a turn for a strain does not turn.
        """
        turns = elastic.law.TAKES_TURNING_STEPS
        self._rotations = NodeRotations(elastic) if turns else None
        self._free = free_nodes
        self._factored_at: FloatArray | None = None
        self._begun: FloatArray | None = None
        self._turns: FloatArray | None = None

    def begin(self, positions: FloatArray) -> None:
        """Take notice that the factorisation was made at positions [m], shape (N, 3)."""
        self._factored_at, self._begun, self._turns = positions.copy(), None, None

    def turn_to(self, positions: FloatArray) -> None:
        """Turn it with the material to positions [m], shape (N, 3)."""
        before = self._factored_at
        if self._rotations is None or before is None or np.array_equal(before, positions):
            self._turns = None
            return
        if self._begun is None:
            self._begun = self._rotations.at(before)[self._free]
        now = self._rotations.at(positions)[self._free]
        self._turns = now @ self._begun.transpose(0, 2, 1)

    def apply(self, solve: Callable[[FloatArray], FloatArray], forces: FloatArray) -> FloatArray:
        """Return the displacement by forces on the free nodes, shape (3 M,) each.

        Args:
            solve: with the factorisation as it was made.
            forces: [N].
        """
        if self._turns is None:
            return solve(forces)
        back = np.einsum('nji,nj->ni', self._turns, forces.reshape(-1, 3))
        solved = solve(back.ravel()).reshape(-1, 3)
        return np.einsum('nij,nj->ni', self._turns, solved).ravel()
