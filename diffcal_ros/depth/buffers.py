# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Device arrays of one tracer that all of its traces use."""

from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth import derivative_kernels, raster_kernels
from diffcal_ros.warp_runtime.device_array import int_array, zero_ints, zero_points
from diffcal_ros.warp_runtime.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
import warp as wp

IntArray = NDArray[np.int32]


class TracerBuffers:
    """The surface and the camera, and work space that every use leaves empty, on a device."""

    def __init__(
        self,
        triangles: IntArray,
        edge_vertices: IntArray,
        edge_faces: IntArray,
        vertex_count: int,
        camera: PinholeCamera,
        device: str,
    ) -> None:
        self.camera = camera
        self.device = device
        self.launch = Launcher(device).launch
        self.face_count = len(triangles)
        self.edge_count = len(edge_vertices)
        pixel_count = camera.width * camera.height
        self.triangles = int_array(triangles, device)
        self.edges = int_array(edge_vertices, device)
        self.edge_faces = int_array(edge_faces, device)
        self.gradient = zero_points(vertex_count, device)
        self.keys = wp.full(pixel_count, value=raster_kernels.EMPTY, dtype=wp.int64, device=device)
        self.segment_counts = zero_ints(len(edge_vertices), device)
        self.segment_ends = zero_ints(len(edge_vertices), device)
        self.pinhole: Any = derivative_kernels.Pinhole()
        for name in ('fx', 'fy', 'cx', 'cy'):
            setattr(self.pinhole, name, getattr(camera, name))
