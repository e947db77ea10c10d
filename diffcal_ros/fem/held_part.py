# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The clamped part of a body: its vertices and nodes, and where they are held."""

from collections.abc import Callable

from diffcal_ros.fem.elements.element import Discretisation
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
# Positions of held vertices or nodes [m] at a fraction 0..1 of their motion.
HeldPath = Callable[[float], FloatArray]


class HeldPart:
    """Clamped vertices of a mesh, and the nodes of its elements between them.

    Attributes:
        vertices: in ascending order, each once, shape (h,).
        nodes: shape (H,).
    """

    def __init__(self, discretisation: Discretisation, vertices: IntArray) -> None:
        """Find the nodes all of whose vertices are held."""
        self.vertices = np.unique(vertices).astype(np.int32)
        self._vertex_count = int(discretisation.node_parents.max()) + 1
        is_held = np.zeros(self._vertex_count, dtype=bool)
        is_held[self.vertices] = True
        parents = discretisation.node_parents
        self.nodes = np.flatnonzero(is_held[parents].all(axis=1)).astype(np.int32)
        self._parents = parents[self.nodes]

    def spread(self, vertex_positions: FloatArray) -> FloatArray:
        """Return positions of the nodes [m], shape (H, 3), for those of the vertices, (h, 3)."""
        everywhere = np.zeros((self._vertex_count, 3))
        everywhere[self.vertices] = vertex_positions
        return everywhere[self._parents].mean(axis=1)

    def node_path(self, path: HeldPath | None) -> HeldPath | None:
        """Return the path of the nodes for that of the vertices; None for None: they stay."""
        return None if path is None else lambda fraction: self.spread(path(fraction))


def shifted_path(path: HeldPath | None, shift: FloatArray) -> HeldPath | None:
    """Return a path in another frame, `shift` [m] away, shape (3,); None for None."""
    return None if path is None else lambda fraction: path(fraction) + shift
