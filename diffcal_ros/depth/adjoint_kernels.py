# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels that pull weights of pixels and of outline segments back to the vertices.

They are the transposes of `push_centres` and `push_outline`.
"""

from diffcal_ros.depth.derivative_kernels import (
    add_to_corners,
    Pinhole,
    pull_to_ends,
    weights_of_pixel,
)
from diffcal_ros.depth.raster_kernels import Plane, Window
from diffcal_ros.depth.silhouette_segments import Segments
import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.kernel(enable_backward=False)
def pull_centres(
    # In:
    triangles: wp.array2d[wp.int32],
    points: wp.array[wp.vec3d],
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    window: Window,
    faces: wp.array[wp.int32],
    depth: wp.array[wp.float64],
    pixels: wp.array[wp.int32],  # (M,) window pixels
    by_depth: wp.array[wp.float64],  # (M,) [1/m]
    # Out:
    gradient: wp.array[wp.vec3d],  # (N,) accumulated
):
    """Pull weights of the depth at pixel centres back to the corners of what they see."""
    index = wp.tid()
    pixel = pixels[index]
    face = faces[pixel]
    weights = weights_of_pixel(planes[face], window, pixel)
    scale = by_depth[index] * depth[pixel] * depth[pixel]
    add_to_corners(triangles, points, screen, face, scale * weights, gradient)


@wp.kernel(enable_backward=False)
def pull_outline(
    # In:
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    edges: wp.array2d[wp.int32],
    segments: Segments,
    chosen: wp.array[wp.int32],  # (M,) of them
    by_motion: wp.array[wp.float64],  # (M,) [1/px]
    # Out:
    gradient: wp.array[wp.vec3d],  # (N,) accumulated
):
    """Pull weights of the outline's outward motion back to the ends of its edges."""
    index = wp.tid()
    pull_to_ends(by_motion[index], segments, chosen[index], points, camera, edges, gradient)
