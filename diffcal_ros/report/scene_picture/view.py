# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Views of a surface for drawings: where points land on the page and what is in front."""

from dataclasses import dataclass

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.rigid_transform import apply, inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

_AMBIENT = 0.45  # Brightness of a face seen edge-on; the rest grows with how much it faces us.


@dataclass(frozen=True)
class View:
    """A perspective or a parallel view.

    Attributes:
        view_from_world: shape (4, 4); x right, y down, z forward, as in a camera.
        camera: makes the view a perspective one in pixels; None: parallel, in millimetres.
    """

    view_from_world: FloatArray
    camera: PinholeCamera | None = None

    def project(self, points_world: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return page coordinates, shape (N, 2), y down, and depths [m], shape (N,)."""
        points_view = apply(self.view_from_world, points_world)
        depth = points_view[..., 2]
        if self.camera is None:
            return 1e3 * points_view[..., :2], depth
        # Points behind the viewer have no place on the page.
        ahead = np.where(depth[..., None] > 1e-6, points_view, np.nan)
        return self.camera.project(ahead), depth

    def toward_viewer(self, points_world: FloatArray) -> FloatArray:
        """Return unit directions from points to the viewer in the world frame."""
        world_from_view = inverse(self.view_from_world)
        if self.camera is None:
            return np.broadcast_to(-world_from_view[:3, 2], points_world.shape)
        direction = world_from_view[:3, 3] - points_world
        unit: FloatArray = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
        return unit


@dataclass(frozen=True)
class PaintedSurface:
    """Front faces in the order in which they are painted, far ones first.

    Attributes:
        faces: rows of the triangle list, shape (f,).
        corners: page coordinates, shape (f, 3, 2).
        brightness: 0 to 1, shape (f,).
        depths: of the faces' centres [m], shape (f,), descending.
    """

    faces: IntArray
    corners: FloatArray
    brightness: FloatArray
    depths: FloatArray


def paint(view: View, points_world: FloatArray, triangles: IntArray) -> PaintedSurface:
    """Sort and shade the triangles that face the viewer.

    Args:
        view: where to look from.
        points_world: [m], shape (V, 3).
        triangles: outward, shape (F, 3).
    """
    corners_world = points_world[triangles]
    normals = np.cross(
        corners_world[:, 1] - corners_world[:, 0], corners_world[:, 2] - corners_world[:, 0]
    )
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    centers = corners_world.mean(axis=1)
    facing = np.sum(normals * view.toward_viewer(centers), axis=1)
    page, depth = view.project(corners_world.reshape(-1, 3))
    corners = page.reshape(-1, 3, 2)
    depths = depth.reshape(-1, 3).mean(axis=1)
    shown = np.flatnonzero((facing > 0.0) & np.isfinite(corners).all(axis=(1, 2)))
    order = shown[np.argsort(-depths[shown], kind='stable')]
    return PaintedSurface(
        faces=order.astype(np.int32),
        corners=corners[order],
        brightness=_AMBIENT + (1.0 - _AMBIENT) * facing[order],
        depths=depths[order],
    )


def visible_vertices(
    view: View, points_world: FloatArray, triangles: IntArray, vertices: IntArray
) -> IntArray:
    """Return those of some vertices that lie on a front face and that no nearer face hides.

    Args:
        view: where to look from.
        points_world: [m], shape (V, 3).
        triangles: outward, shape (F, 3).
        vertices: the ones asked about.
    """
    painted = paint(view, points_world, triangles)
    page, depth = view.project(points_world)
    fronts = triangles[painted.faces]
    hidden = np.zeros(len(points_world), dtype=bool)
    candidates = np.intersect1d(fronts, vertices)
    slack = 1e-3 * float(np.ptp(points_world, axis=0).max())
    for corners, face in zip(painted.corners, fronts, strict=True):
        inside = _inside(corners, page[candidates]) & ~np.isin(candidates, face)
        hidden[candidates[inside & (depth[candidates] > depth[face].max() + slack)]] = True
    return candidates[~hidden[candidates]].astype(np.int32)


def _inside(corners: FloatArray, points: FloatArray) -> NDArray[np.bool_]:
    """Tell which page points lie in a triangle of either winding."""
    sides = np.roll(corners, -1, axis=0) - corners
    offsets = points[:, None] - corners
    turns = sides[:, 0] * offsets[..., 1] - sides[:, 1] * offsets[..., 0]
    return np.asarray((turns > 0).all(axis=1) | (turns < 0).all(axis=1))
