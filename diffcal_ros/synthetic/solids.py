# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Boxes and walls, seen by exact intersection of each pixel's ray."""

from dataclasses import dataclass

from diffcal_ros.rigid_transform import inverse
from diffcal_ros.synthetic.scan import Scan, Thing
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Box:
    """A solid box.

    Attributes:
        world_from_box: its pose, shape (4, 4).
        low: lower corner in its own frame [m], shape (3,).
        high: upper corner [m], shape (3,).
        thing: what it is.
    """

    world_from_box: FloatArray
    low: FloatArray
    high: FloatArray
    thing: Thing

    def corners(self) -> FloatArray:
        """Return the corners in the world frame [m], shape (8, 3)."""
        picks = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing='ij'), -1).reshape(-1, 3)
        own = np.where(picks == 0, self.low, self.high)
        return own @ self.world_from_box[:3, :3].T + self.world_from_box[:3, 3]

    def scan(self, rays: FloatArray, camera_from_world: FloatArray) -> Scan:
        """See the box.

        Args:
            rays: viewing rays with z = 1 in the camera's frame, shape (H, W, 3).
            camera_from_world: pose of the camera, shape (4, 4).
        """
        box_from_camera = inverse(camera_from_world @ self.world_from_box)
        eye = box_from_camera[:3, 3]
        directions = rays @ box_from_camera[:3, :3].T
        # A ray along a face divides by zero; infinities then compare as they should.
        with np.errstate(divide='ignore', invalid='ignore'):
            to_low = (self.low - eye) / directions
            to_high = (self.high - eye) / directions
        entries, exits = np.fmin(to_low, to_high), np.fmax(to_low, to_high)
        entry = entries.max(axis=-1)
        is_hit = (entry > 0.0) & (entry <= exits.min(axis=-1))
        face = entries.argmax(axis=-1)
        slant = np.abs(np.take_along_axis(directions, face[..., None], axis=-1)[..., 0])
        return _scan(is_hit, entry, slant / np.linalg.norm(rays, axis=-1), self.thing)


@dataclass(frozen=True)
class Wall:
    """A plane without end.

    Attributes:
        point: on it, in the world frame [m], shape (3,).
        normal: unit, shape (3,).
    """

    point: FloatArray
    normal: FloatArray

    def scan(self, rays: FloatArray, camera_from_world: FloatArray) -> Scan:
        """See the wall; see `Box.scan`."""
        normal = camera_from_world[:3, :3] @ self.normal
        point = camera_from_world[:3, :3] @ self.point + camera_from_world[:3, 3]
        with np.errstate(divide='ignore', invalid='ignore'):
            depth = (normal @ point) / (rays @ normal)
        slant = np.abs(rays @ normal) / np.linalg.norm(rays, axis=-1)
        return _scan(np.isfinite(depth) & (depth > 0.0), depth, slant, Thing.WALL)


def _scan(is_hit: NDArray[np.bool_], depth: FloatArray, cosine: FloatArray, thing: Thing) -> Scan:
    return Scan(
        np.where(is_hit, depth, np.nan),
        np.where(is_hit, cosine, 1.0),
        np.where(is_hit, int(thing), int(Thing.NOTHING)).astype(np.int32),
    )
