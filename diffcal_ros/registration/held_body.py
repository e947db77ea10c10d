# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The soft body that a rigid part holds, as far as it tells which pose of the part is right."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# The body's root reaches so far from the part: a share of the body's length, at least [m].
_ROOT, _LEAST_ROOT = 0.15, 0.01
# Angles by which its end may hang, from next to nothing [rad].
_BENDS = np.linspace(1e-6, 1.8, 10)


@dataclass(frozen=True)
class BodyAtRest:
    """The body that the part holds, in the same frame.

    Attributes:
        positions: surface vertices at rest, object frame [m], shape (V, 3).
        triangles: outward, shape (F, 3).
        gravity: its direction in the object frame, shape (3,); None: it is not known there.
    """

    positions: FloatArray
    triangles: IntArray
    gravity: FloatArray | None = None

    def root(self, points: FloatArray) -> BoolArray:
        """Tell which triangles are near the part, where the body hardly bends, shape (F,).

        Args:
            points: on the part's surface, object frame [m], shape (N, 3).
        """
        length = float(np.ptp(self.positions, axis=0).max())
        distance, _ = cKDTree(points).query(self.positions[self.triangles].mean(axis=1))
        near: BoolArray = distance <= max(_ROOT * length, _LEAST_ROOT)
        return near

    def hanging(self, root: BoolArray) -> list[FloatArray]:
        """Return shapes bent more and more along gravity, as arcs from the root on.

        Rough ones, which tell on which side the body hangs; no stiffness stands for them.

        Args:
            root: of `root`, shape (F,).

        Returns:
            Positions [m], shape (V, 3) each; none where gravity is not known.
        """
        if self.gravity is None or not root.any() or root.all():
            return []
        middles = self.positions[self.triangles].mean(axis=1)
        start = middles[root].mean(axis=0)
        along = middles[~root].mean(axis=0) - start
        along /= np.linalg.norm(along)
        down = self.gravity - (self.gravity @ along) * along
        if np.linalg.norm(down) <= 1e-3 * np.linalg.norm(self.gravity):
            return []
        down /= np.linalg.norm(down)
        place = (self.positions - start) @ along
        free = np.maximum(place, 0.0)
        across = self.positions - start - free[:, None] * along
        shapes = []
        for bend in _BENDS:
            curvature = bend / free.max()
            angle = curvature * free
            axis = (np.sin(angle) / curvature)[:, None] * along
            axis += ((1.0 - np.cos(angle)) / curvature)[:, None] * down
            # Sections turn with the axis, in the plane of the bend.
            forward, low = across @ along, across @ down
            turned = (
                across
                + ((np.cos(angle) - 1.0) * forward - np.sin(angle) * low)[:, None] * along
                + (np.sin(angle) * forward + (np.cos(angle) - 1.0) * low)[:, None] * down
            )
            shapes.append(start + axis + turned)
        return shapes
