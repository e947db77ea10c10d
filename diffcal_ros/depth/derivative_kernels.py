# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels for the derivative of a depth image by the vertices, backwards and forwards.

Inside a triangle 1/z at a fixed pixel is the mean of its corners' 1/z with the image barycentric
weights w. Where the ray meets the plane follows the corners as

    dz/dcorner = z^2 w / z_corner * m,    m = n / (n . p),

with the triangle's normal n and any of its points p: one vector m a triangle, one number a pixel
and corner.
"""

from diffcal_ros.depth.raster_kernels import (
    Plane,
    weights_at,
    Window,
)
from diffcal_ros.depth.silhouette_segments import Segments
import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.struct
class Pinhole:
    """Intrinsics [px]."""

    fx: wp.float64
    fy: wp.float64
    cx: wp.float64
    cy: wp.float64


@wp.func
def plane_vector(triangles: wp.array2d[wp.int32], points: wp.array[wp.vec3d], face: wp.int32):
    """Return m = n / (n . p) [1/m]."""
    p = points[triangles[face, 0]]
    normal = wp.cross(points[triangles[face, 1]] - p, points[triangles[face, 2]] - p)
    return normal / wp.dot(normal, p)


@wp.func
def add_to_corners(
    triangles: wp.array2d[wp.int32],
    points: wp.array[wp.vec3d],
    screen: wp.array[wp.vec3d],
    face: wp.int32,
    sums: wp.vec3d,
    gradient: wp.array[wp.vec3d],
):
    """Add a triangle's share: sums over pixels of derivative times z^2 times weights."""
    m = plane_vector(triangles, points, face)
    for corner in range(3):
        vertex = triangles[face, corner]
        wp.atomic_add(gradient, vertex, (sums[corner] * screen[vertex][2]) * m)


@wp.func
def pushed(
    triangles: wp.array2d[wp.int32],
    screen: wp.array[wp.vec3d],
    tangents: wp.array2d[wp.vec3d],
    face: wp.int32,
    weights: wp.vec3d,
    m: wp.vec3d,
    parameter: wp.int32,
):
    """Return dz / z^2 along one tangent."""
    moved = wp.vec3d()
    for corner in range(3):
        vertex = triangles[face, corner]
        moved += (weights[corner] * screen[vertex][2]) * tangents[vertex, parameter]
    return wp.dot(m, moved)


@wp.func
def screen_rate(points: wp.array[wp.vec3d], camera: Pinhole, vertex: wp.int32, normal: wp.vec2d):
    """Return the derivative of a vertex's image position along a normal by its position."""
    p = points[vertex]
    inverse = wp.float64(1.0) / p[2]
    across = normal[0] * camera.fx * inverse
    down = normal[1] * camera.fy * inverse
    return wp.vec3d(across, down, -(across * p[0] + down * p[1]) * inverse)


@wp.struct
class EndRates:
    """How the outward motion of a point on an edge follows the edge's ends.

    Attributes:
        a: vertex at one end; `b` at the other.
        at_a: derivative of the motion by its position [px/m]; `at_b` by the other's.
    """

    a: wp.int32
    b: wp.int32
    at_a: wp.vec3d
    at_b: wp.vec3d


@wp.func
def end_rates(
    segments: Segments,
    segment: wp.int32,
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    edges: wp.array2d[wp.int32],
):
    """Return how a segment's outward motion follows the ends of its edge."""
    fraction = segments.fractions[segment]
    normal = segments.normals[segment]
    ends = EndRates()
    ends.a = edges[segments.edges[segment], 0]
    ends.b = edges[segments.edges[segment], 1]
    ends.at_a = (wp.float64(1.0) - fraction) * screen_rate(points, camera, ends.a, normal)
    ends.at_b = fraction * screen_rate(points, camera, ends.b, normal)
    return ends


@wp.func
def motion_of(ends: EndRates, tangents: wp.array2d[wp.vec3d], parameter: wp.int32):
    """Return the outward motion [px] for the tangents of one parameter."""
    return wp.dot(ends.at_a, tangents[ends.a, parameter]) + wp.dot(
        ends.at_b, tangents[ends.b, parameter]
    )


@wp.func
def pull_to_ends(
    scale: wp.float64,
    segments: Segments,
    segment: wp.int32,
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    edges: wp.array2d[wp.int32],
    gradient: wp.array[wp.vec3d],
):
    """Pull a weight of a segment's outward motion back to the ends of its edge."""
    ends = end_rates(segments, segment, points, camera, edges)
    wp.atomic_add(gradient, ends.a, scale * ends.at_a)
    wp.atomic_add(gradient, ends.b, scale * ends.at_b)


@wp.func
def weights_of_pixel(plane: Plane, window: Window, pixel: wp.int32):
    """Return the weights of a triangle's corners at the centre of a window's pixel."""
    column = wp.float64(window.left + pixel % window.width)
    row = wp.float64(window.top + pixel // window.width)
    return weights_at(plane, column, row)


@wp.kernel(enable_backward=False)
def push_centres(
    # In:
    triangles: wp.array2d[wp.int32],
    points: wp.array[wp.vec3d],
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    window: Window,
    faces: wp.array[wp.int32],
    depth: wp.array[wp.float64],
    pixels: wp.array[wp.int32],  # (M,) window pixels
    tangents: wp.array2d[wp.vec3d],  # (N, k) displacement per unit of each parameter
    # Out:
    rates: wp.array2d[wp.float64],  # (M, k) change of z [m]
):
    """Push tangents to the depth at pixel centres."""
    index = wp.tid()
    pixel = pixels[index]
    face = faces[pixel]
    weights = weights_of_pixel(planes[face], window, pixel)
    m = plane_vector(triangles, points, face)
    square = depth[pixel] * depth[pixel]
    for parameter in range(tangents.shape[1]):
        rates[index, parameter] = square * pushed(
            triangles, screen, tangents, face, weights, m, parameter
        )


@wp.kernel(enable_backward=False)
def push_outline(
    # In:
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    edges: wp.array2d[wp.int32],
    segments: Segments,
    chosen: wp.array[wp.int32],  # (M,) of them
    tangents: wp.array2d[wp.vec3d],
    # Out:
    rates: wp.array2d[wp.float64],  # (M, k) outward motion of the outline [px]
):
    """Push tangents to the outline's motion along its normal."""
    index = wp.tid()
    ends = end_rates(segments, chosen[index], points, camera, edges)
    for parameter in range(tangents.shape[1]):
        rates[index, parameter] = motion_of(ends, tangents, parameter)
