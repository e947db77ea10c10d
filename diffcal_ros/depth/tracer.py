# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth tracer: positions and a camera in, a depth image and its derivatives out.

Front faces are rasterised into the window that the body covers; rays are cast only where an
outline needs to know what lies behind it.
"""

from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth import raster_kernels
from diffcal_ros.depth.buffers import TracerBuffers
from diffcal_ros.depth.surface_edges import surface_edges
from diffcal_ros.depth.trace import Trace
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.warp_runtime.device_array import point_array
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

_NEAREST = 1e-3  # A body closer to the camera than this [m] is behind it, or a wrong pose.


class OutOfViewError(NotSimulatedError):
    """The body is not in front of the camera; the message says where it is."""


class DepthTracer:
    """Traces one surface seen by one camera."""

    def __init__(
        self, triangles: IntArray, vertex_count: int, camera: PinholeCamera, *, device: str = 'cpu'
    ) -> None:
        """Prepare buffers.

        Args:
            triangles: outward triangles, shape (F, 3).
            vertex_count: number of positions that `trace` will be given.
            camera: of the depth image, without distortion.
            device: Warp device.
        """
        self.camera = camera
        self.device = device
        self.triangles = triangles
        self.edge_vertices, self.edge_faces = surface_edges(triangles)
        self._buffers = TracerBuffers(
            triangles, self.edge_vertices, self.edge_faces, vertex_count, camera, device
        )

    def trace(self, points_camera: FloatArray) -> Trace:
        """Trace the surface.

        Args:
            points_camera: vertex positions in the camera frame [m], shape (N, 3).

        Raises:
            OutOfViewError: when no part of the body is in the image, or one is behind it.
        """
        nearest = float(points_camera[:, 2].min())
        if not nearest > _NEAREST:
            raise OutOfViewError(
                f"the body's nearest point is at z = {nearest:.3f} m of the camera: it must lie "
                "in front of it; check the placement, the marker's pose and the camera pose"
            )
        camera = self.camera
        screen = np.empty_like(points_camera)
        screen[:, 2] = 1.0 / points_camera[:, 2]
        screen[:, 0] = camera.fx * points_camera[:, 0] * screen[:, 2] + camera.cx
        screen[:, 1] = camera.fy * points_camera[:, 1] * screen[:, 2] + camera.cy
        low, high = screen[:, :2].min(axis=0), screen[:, :2].max(axis=0)
        left, top = max(int(np.floor(low[0])) - 1, 0), max(int(np.floor(low[1])) - 1, 0)
        right = min(int(np.ceil(high[0])) + 1, camera.width - 1)
        bottom = min(int(np.ceil(high[1])) + 1, camera.height - 1)
        if right < left or bottom < top:
            raise OutOfViewError(
                f'the body is seen at columns {low[0]:.0f} to {high[0]:.0f} and rows '
                f'{low[1]:.0f} to {high[1]:.0f} of a {camera.width}x{camera.height} image: it '
                "must be in the camera's view; check the placement and the camera pose"
            )
        window: Any = raster_kernels.Window()
        window.left, window.top = left, top
        window.width, window.height = right - left + 1, bottom - top + 1
        # The nearest point takes all of the 31 bits that 1/z has in the z-buffer.
        points, shown = (point_array(each, self.device) for each in (points_camera, screen))
        return Trace(self._buffers, points, shown, window, 0.999 * 2.0**31 * nearest)


def pose_gradient(points_camera: FloatArray, gradient: FloatArray) -> FloatArray:
    """Return the derivative by a rigid motion of the points in the camera frame.

    Args:
        points_camera: [m], shape (N, 3).
        gradient: derivative of a scalar by them, shape (N, 3).

    Returns:
        By translation, then by rotation vector about the camera's origin, shape (6,).
    """
    return np.concatenate([gradient.sum(axis=0), np.cross(points_camera, gradient).sum(axis=0)])
