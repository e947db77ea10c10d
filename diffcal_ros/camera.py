# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The pinhole camera; pixel centres at integers, ROS optical axes (x right, y down, z forward)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Focal length over width or height, at which 160 degrees are seen at once: less is no lens.
SHORTEST_FOCAL_LENGTH = 0.088


@dataclass(frozen=True)
class PinholeCamera:
    """Intrinsics of one image.

    Attributes:
        width: columns [px].
        height: rows [px].
        fx: focal length along columns [px].
        fy: focal length along rows [px].
        cx: column of the optical axis [px].
        cy: row of the optical axis [px].
        distortion: OpenCV's plumb_bob or rational coefficients; empty means none.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.width <= 0 or self.height <= 0:
            raise ValueError(
                f'camera size is {self.width}x{self.height}: both sides must be positive'
            )
        values = (self.fx, self.fy, self.cx, self.cy, *self.distortion)
        if not np.isfinite(values).all():
            raise ValueError(f'camera intrinsics hold NaN or Inf: {values}')
        if self.fx <= 0.0 or self.fy <= 0.0:
            raise ValueError(
                f'focal length is fx={self.fx:g}, fy={self.fy:g}: both must be positive; '
                'an uncalibrated camera publishes zeros, so calibrate it or give the '
                "intrinsics in the scene file under 'camera'"
            )
        least = (self.width * SHORTEST_FOCAL_LENGTH, self.height * SHORTEST_FOCAL_LENGTH)
        if self.fx < least[0] or self.fy < least[1]:
            raise ValueError(
                f'focal length is fx={self.fx:g}, fy={self.fy:g} px for {self.width}x'
                f'{self.height} pixels, more than 160 degrees in view: it is counted in pixels, '
                f'at least {least[0]:g} and {least[1]:g}'
            )

    @property
    def K(self) -> FloatArray:  # noqa: N802
        """Intrinsic matrix [px], shape (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def is_distorted(self) -> bool:
        """Tell whether any distortion coefficient is not zero."""
        return any(self.distortion)

    def project(self, points_camera: FloatArray) -> FloatArray:
        """Project points [m], shape (..., 3), to pixels (column, row), shape (..., 2).

        Distortion is left out: depth images are rectified.
        """
        depth = points_camera[..., 2]
        return np.stack(
            [
                self.fx * points_camera[..., 0] / depth + self.cx,
                self.fy * points_camera[..., 1] / depth + self.cy,
            ],
            axis=-1,
        )

    def rays(self) -> FloatArray:
        """Return each pixel's viewing ray with z = 1, shape (H, W, 3)."""
        directions = self.directions(slice(0, self.height), slice(0, self.width))
        return np.dstack([directions, np.ones((self.height, self.width))])

    def directions(self, rows: slice, columns: slice) -> FloatArray:
        """Return x / z and y / z of the pixels of a window, shape (h, w, 2)."""
        x = (np.arange(columns.start, columns.stop) - self.cx) / self.fx
        y = (np.arange(rows.start, rows.stop) - self.cy) / self.fy
        return np.stack(np.meshgrid(x, y), axis=-1)

    def back_project(self, depth: FloatArray) -> FloatArray:
        """Lift a depth image to points in the camera frame.

        Args:
            depth: z along the optical axis [m], shape (H, W); NaN where invalid.

        Returns:
            Points [m], shape (H, W, 3).

        Raises:
            ValueError: when the image has another size than the camera.
        """
        if depth.shape != (self.height, self.width):
            raise ValueError(
                f'depth is {depth.shape}, camera expects {(self.height, self.width)}: '
                'check that camera_info matches the depth topic'
            )
        return self.rays() * depth[..., None]
