# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Ways in which a body may be held: at one of its ends, from a plane on."""

from dataclasses import dataclass

from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# A body is held at an end of an axis along which it is nearly as long as along its longest one.
_LONG = 0.7
# A principal axis within this of an axis of the mesh's own frame is taken for it.
_ALIGNED = float(np.cos(np.deg2rad(12.0)))
# So many vertices in one plane are no chance.
_ROW = 4
# Before anything is known, this share of the length is held.
USUAL_SHARE = 0.15


@dataclass(frozen=True)
class Hold:
    """An end of the body, held from a plane on.

    Attributes:
        direction: unit, from the body to the clamp, object frame, shape (3,).
        plane: where the clamp begins: coordinate along `direction` in the object frame [m].
    """

    direction: FloatArray
    plane: float

    @property
    def axis(self) -> int | None:
        """Number of the frame's axis that `direction` runs along; None where it is oblique."""
        place = int(np.argmax(np.abs(self.direction)))
        return place if abs(self.direction[place]) > 1.0 - 1e-9 else None

    def vertices(self, mesh: TetMesh) -> IntArray:
        """Return the held vertices, those on the plane among them, shape (h,)."""
        along = mesh.rest_positions @ self.direction
        reach = 1e-6 * float(np.ptp(along))
        return np.flatnonzero(along >= self.plane - reach).astype(np.int32)

    def moved(self, plane: float) -> 'Hold':
        """Return the same end, held from another plane on [m]."""
        return Hold(self.direction, plane)

    def at_row(self, mesh: TetMesh, doubt: float) -> 'Hold':
        """Return the same end, held from the nearest row of vertices on where one is near enough.

        A mesh that was made for a clamp has vertices where that begins. A plane between two rows
        frees the body as far as the next one.

        Args:
            mesh: the body at rest.
            doubt: how far the plane may be off [m].
        """
        along = mesh.rest_positions @ self.direction
        grain = 1e-6 * float(np.ptp(along))
        near = np.sort(along[np.abs(along - self.plane) <= doubt])
        rows = np.split(near, np.flatnonzero(np.diff(near) > grain) + 1)
        planes = [float(row.mean()) for row in rows if len(row) >= _ROW]
        return self.moved(
            min(planes, key=lambda plane: abs(plane - self.plane), default=self.plane)
        )


def possible_holds(mesh: TetMesh, share: float = USUAL_SHARE) -> list[Hold]:
    """List the ends at which a body may be held: both of each long axis.

    Args:
        mesh: the body at rest.
        share: of the length that is held.
    """
    middle = mesh.rest_positions - mesh.rest_positions.mean(axis=0)
    holds = []
    for axis in _long_axes(middle):
        for direction in (axis, -axis):
            along = mesh.rest_positions @ direction
            high = float(along.max())
            hold = Hold(direction, high - share * (high - float(along.min())))
            holds.append(_with_enough(hold, mesh))
    return holds


def _long_axes(points: FloatArray) -> list[FloatArray]:
    """Return the axes along which a body is long: the frame's own, or else principal ones."""
    principal = np.linalg.svd(points, full_matrices=False)[2]
    is_aligned = np.abs(principal[0]).max() > _ALIGNED
    axes = np.eye(3) if is_aligned else principal
    lengths = np.ptp(points @ axes.T, axis=0)
    return [
        axis for axis, length in zip(axes, lengths, strict=True) if length >= _LONG * lengths.max()
    ]


def _with_enough(hold: Hold, mesh: TetMesh) -> Hold:
    """Move the plane until three vertices not on a line, and not all, are held."""
    along = np.sort(np.unique(np.round(mesh.rest_positions @ hold.direction, 9)))[::-1]
    for plane in (hold.plane, *along[along < hold.plane]):
        moved = hold.moved(float(plane))
        held = mesh.rest_positions[moved.vertices(mesh)]
        if len(held) >= 3 and np.linalg.matrix_rank(held - held.mean(axis=0), tol=1e-6) >= 2:
            return moved
    return hold
