# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A bent body reduced to a few points: of its surface in view, and of the space beside it."""

from diffcal_ros.proposal.bent_shape import BentShape
from diffcal_ros.registration.surface_sample import ShapeSample, spread, spread_over
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# A surface is in view where its normal is at least so much towards the camera.
_FACING = 0.2
# The body is drawn into a grid of so many cells along its longest side.
_CELLS = 60
# Space beside a body that is looked at begins and ends this far from its outline [cells].
_BESIDE = (1.6, 3.2)
# The end of a body is this share of its free length.
_END = 0.12


class ShapeSampler:
    """Draws points on one shape, again and again the same ones."""

    def __init__(self, mesh: TetMesh, shape: BentShape, count: int) -> None:
        """Choose points evenly over the surface.

        Args:
            mesh: the body at rest.
            shape: how it is bent.
            count: of points over the whole surface.
        """
        triangles = mesh.surface_triangles
        corners = shape.positions[triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = np.linalg.norm(normals, axis=1)
        chosen, shares = spread_over(areas, count)
        self._points = np.einsum('nc,ncx->nx', shares, corners[chosen])
        self._normals = (normals / np.maximum(areas, 1e-300)[:, None])[chosen]
        rest = np.einsum('nc,ncx->nx', shares, mesh.rest_positions[triangles][chosen])
        along = rest @ shape.hold.direction
        self._is_free = along < shape.hold.plane
        end = along.min() + _END * (shape.hold.plane - along.min())
        self._is_end = along < end

    def look(
        self, rotation: FloatArray, view: FloatArray, surface: int, beside: int
    ) -> ShapeSample | None:
        """Return points as a camera has them that sees the body in some direction.

        Args:
            rotation: camera_from_object, shape (3, 3).
            view: unit, from the camera to the body, shape (3,).
            surface: points on the surface, at most.
            beside: points beside it, at most.

        Returns:
            The points; None where hardly anything of the free part is in view.
        """
        points = self._points @ rotation.T
        is_facing = self._normals @ rotation.T @ view < -_FACING
        in_view, held = self._is_free & is_facing, points[is_facing & ~self._is_free]
        if np.count_nonzero(in_view) < 10:
            return None
        seen = points[in_view]
        middle = seen[np.argmin(np.linalg.norm(seen - seen.mean(axis=0), axis=1))]
        chosen = seen[spread(len(seen), surface)]
        around, owners = _beside(points, self._is_free, view, middle)
        end = points[self._is_end].mean(axis=0)
        along = end - points[~self._is_end & self._is_free].mean(axis=0)
        is_beyond = self._is_end[owners] & ((around - points[owners]) @ along > 0.0)
        beyond = around[is_beyond]
        return ShapeSample(
            np.vstack([middle, chosen]) - middle,
            around[spread(len(around), beside)] - middle,
            beyond[spread(len(beyond), beside // 2)] - middle,
            held[spread(len(held), beside // 2)] - middle,
            middle,
        )


def _beside(
    points: FloatArray, is_free: NDArray[np.bool_], view: FloatArray, middle: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return points around the outline of the free part, at the depth of what is next to them.

    Beside each, shape (M, 3), the number of the point that is next to it, shape (M,).
    """
    # As seen along the ray to the middle: two coordinates across it, a third along it.
    right = np.cross([0.0, 1.0, 0.0], view)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(view, right), view])
    # A coordinate a row: NumPy is ten times slower down columns.
    *across, along = axes @ (points - middle).T
    low = np.array([own.min() for own in across])
    cell = max(float(own.max() - first) for own, first in zip(across, low, strict=True)) / _CELLS
    rim = int(_BESIDE[1]) + 2
    rows, columns = (
        ((own - first) / cell).astype(int) + rim for own, first in zip(across, low, strict=True)
    )
    numbers = np.full((rows.max() + rim + 1, columns.max() + rim + 1), -1)
    order = np.argsort(-along)  # The nearest is written last.
    numbers[rows[order], columns[order]] = order
    filled = ndimage.binary_closing(numbers >= 0, iterations=2, border_value=0)
    distance, near = ndimage.distance_transform_edt(~filled, return_indices=True)
    # From the filled cell to a point that was drawn.
    nearest = ndimage.distance_transform_edt(numbers < 0, return_indices=True)[1]
    owner = numbers[tuple(nearest[:, near[0], near[1]])]
    ring = (distance >= _BESIDE[0]) & (distance <= _BESIDE[1]) & is_free[owner]
    cells = np.argwhere(ring)
    around = np.column_stack([low + (cells - rim + 0.5) * cell, along[owner[ring]]])
    return around @ axes + middle, owner[ring].astype(np.int32)
