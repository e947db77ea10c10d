# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels that pull weights of pixels and of outline segments back to the vertices.

They are the transposes of `push_centres` and `push_outline`.
"""

from diffcal_ros.depth.derivative_kernels import (
    Pinhole,
    plane_vector,
    pull_to_ends,
    weights_of_pixel,
)
from diffcal_ros.depth.raster_kernels import Plane, Window
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
    m = plane_vector(triangles, points, face)
    scale = by_depth[index] * depth[pixel] * depth[pixel]
    for corner in range(3):
        vertex = triangles[face, corner]
        wp.atomic_add(gradient, vertex, (scale * weights[corner] * screen[vertex][2]) * m)


@wp.kernel(enable_backward=False)
def pull_outline(
    # In:
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    edges: wp.array2d[wp.int32],
    segment_edges: wp.array[wp.int32],
    segment_fractions: wp.array[wp.float64],
    segment_normals: wp.array[wp.vec2d],
    segments: wp.array[wp.int32],  # (M,)
    by_motion: wp.array[wp.float64],  # (M,) [1/px]
    # Out:
    gradient: wp.array[wp.vec3d],  # (N,) accumulated
):
    """Pull weights of the outline's outward motion back to the ends of its edges."""
    index = wp.tid()
    segment = segments[index]
    edge = segment_edges[segment]
    fraction = segment_fractions[segment]
    normal = segment_normals[segment]
    weight = by_motion[index]
    pull_to_ends(
        weight, fraction, normal, points, camera, edges[edge, 0], edges[edge, 1], gradient
    )
