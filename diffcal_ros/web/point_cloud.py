# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a depth camera measured, as points with colours."""

from collections.abc import Callable
from dataclasses import dataclass

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.report import palette
from diffcal_ros.rigid_transform import apply, inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ByteArray = NDArray[np.uint8]
BoolArray = NDArray[np.bool_]

_GREY = 150
# Beyond the body every so many rows and columns are shown.
_STRIDE = 2
# Half the scale of distances is at least this [m], or so many median gaps.
_LEAST_SCALE, _GAPS = 0.0005, 4.0


@dataclass(frozen=True)
class PointCloud:
    """Measured points.

    Attributes:
        points: in the world frame [m], shape (N, 3).
        pixels: rows and columns of the depth image, shape (N,) each.
    """

    points: FloatArray
    pixels: tuple[NDArray[np.int64], NDArray[np.int64]]

    def colors(self, image: ByteArray, is_known: BoolArray) -> ByteArray:
        """Take colours of an RGB image, shape (H, W, 3), grey where not known; shape (N, 3)."""
        found = image[self.pixels].copy()
        found[~is_known[self.pixels]] = _GREY
        return found


def point_cloud(observation: Observation, rows: slice, columns: slice) -> PointCloud:
    """Lift a depth image to the world.

    Args:
        observation: measured.
        rows: of a window in which every pixel is kept; beyond it every fourth one.
        columns: of that window.
    """
    is_kept = np.zeros(observation.depth.shape, dtype=bool)
    is_kept[::_STRIDE, ::_STRIDE] = True
    is_kept[rows, columns] = True
    is_kept &= np.isfinite(observation.depth)
    points = observation.camera.back_project(observation.depth.astype(np.float64))
    pixels = np.nonzero(is_kept)
    world_from_depth = inverse(observation.depth_from_world)
    return PointCloud(apply(world_from_depth, points[pixels]), (pixels[0], pixels[1]))


def distance_colors(residual: FloatArray, median_gap: float) -> tuple[ByteArray, BoolArray, float]:
    """Colour pixels by how far the measured surface is behind the simulated one.

    Args:
        residual: measured less simulated depth [m], shape (H, W); NaN beside the body.
        median_gap: of the fit [m].

    Returns:
        RGB, shape (H, W, 3), blue where measured nearer, orange where farther; where it is known,
        shape (H, W); and the distance at the ends of the scale [m].
    """
    scale = max(_LEAST_SCALE, _GAPS * median_gap) if np.isfinite(median_gap) else _LEAST_SCALE
    is_known = np.isfinite(residual)
    shades: Callable[[FloatArray], FloatArray] = palette.residual_map()
    colors = shades(0.5 + 0.5 * np.nan_to_num(residual) / scale)[..., :3]
    return np.round(255.0 * colors).astype(np.uint8), is_known, scale
