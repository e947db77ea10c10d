# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Device arrays of one tracer, kept from image to image."""

from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth import derivative_kernels, raster_kernels
from diffcal_ros.device_array import int_array, zero_floats, zero_ints, zero_points
from diffcal_ros.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
import warp as wp

IntArray = NDArray[np.int32]


class TracerBuffers:
    """Inputs, z-buffer and work space on a device."""

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
        # Counts traces: a trace ends when its tracer traces again.
        self.generation = 0
        pixel_count = camera.width * camera.height
        self.triangles = int_array(triangles, device)
        self.edges = int_array(edge_vertices, device)
        self.edge_faces = int_array(edge_faces, device)
        self.points = zero_points(vertex_count, device)
        self.screen = zero_points(vertex_count, device)
        self.gradient = zero_points(vertex_count, device)
        self.planes = wp.zeros(len(triangles), dtype=raster_kernels.Plane, device=device)
        self.keys = wp.full(pixel_count, value=raster_kernels.EMPTY, dtype=wp.int64, device=device)
        self.faces = zero_ints(pixel_count, device)
        self.depth = zero_floats(pixel_count, device)
        tile = int(raster_kernels.TILE)
        tile_count = (camera.width // tile + 2) * (camera.height // tile + 2)
        self.tile_counts = zero_ints(tile_count, device)
        self.tile_ends = zero_ints(tile_count, device)
        self.segment_counts = zero_ints(len(edge_vertices), device)
        self.segment_ends = zero_ints(len(edge_vertices), device)
        self.pinhole: Any = derivative_kernels.Pinhole()
        for name in ('fx', 'fy', 'cx', 'cy'):
            setattr(self.pinhole, name, getattr(camera, name))
