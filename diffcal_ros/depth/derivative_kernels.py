# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels for the derivative of a depth image by the vertices, backwards and forwards.

Inside a triangle 1/z at a fixed pixel is the mean of its corners' 1/z with the image barycentric
weights w. Where the ray meets the plane follows the corners as

    dz/dcorner = z^2 w / z_corner * m,    m = n / (n . p),

with the triangle's normal n and any of its points p: one vector m a triangle, one number a pixel
and corner. At a visible outline the pixel's mean changes by (z in front - z behind) times the area
that the outline sweeps (Arnavaz et al. 2023, equations 7 and 8).
"""

from diffcal_ros.depth.raster_kernels import (
    columns_inside,
    inverse_depth_at,
    Plane,
    rows_of,
    weights_at,
    Window,
)
from diffcal_ros.depth.silhouette_kernels import cell_of
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


@wp.kernel(enable_backward=False)
def pull_back_centres(
    # In:
    triangles: wp.array2d[wp.int32],
    points: wp.array[wp.vec3d],  # (N,) camera frame [m]
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    window: Window,
    faces: wp.array[wp.int32],  # (window pixels,)
    marks: wp.array[wp.int32],  # (window pixels,) 1 where the area average is used
    by_image: wp.array[wp.float64],  # (window pixels,)
    # Out:
    gradient: wp.array[wp.vec3d],  # (N,) accumulated
):
    """Pull the pixel centres that a triangle is seen at back to its corners."""
    face = wp.tid()
    plane = planes[face]
    if not plane.is_front:
        return
    rows = rows_of(
        screen[triangles[face, 0]], screen[triangles[face, 1]], screen[triangles[face, 2]], window
    )
    sums = wp.vec3d()
    for row in range(rows[0], rows[1] + 1):
        y = wp.float64(row)
        span = columns_inside(plane, y)
        first = wp.max(wp.int32(wp.ceil(span[0])), window.left)
        last = wp.min(wp.int32(wp.floor(span[1])), window.left + window.width - 1)
        start = (row - window.top) * window.width - window.left
        for column in range(first, last + 1):
            pixel = start + column
            if faces[pixel] == face and marks[pixel] == 0:
                x = wp.float64(column)
                near = inverse_depth_at(plane, x, y)
                sums += (by_image[pixel] / (near * near)) * weights_at(plane, x, y)
    add_to_corners(triangles, points, screen, face, sums, gradient)


@wp.kernel(enable_backward=False)
def pull_back_parts(
    # In:
    triangles: wp.array2d[wp.int32],
    points: wp.array[wp.vec3d],
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    pixels: wp.array[wp.int32],  # (M,)
    part_faces: wp.array2d[wp.int32],  # (M, parts)
    part_sums: wp.array2d[wp.vec3d],  # (M, parts)
    by_image: wp.array[wp.float64],
    # Out:
    gradient: wp.array[wp.vec3d],
):
    """Pull the inside of the area-averaged pixels back to the vertices."""
    index = wp.tid()
    for part in range(part_faces.shape[1]):
        face = part_faces[index, part]
        if face < 0:
            continue
        area = part_sums[index, part][0]
        column = part_sums[index, part][1] / area
        row = part_sums[index, part][2] / area
        nearness = inverse_depth_at(planes[face], column, row)
        scale = by_image[pixels[index]] * area / (nearness * nearness)
        add_to_corners(
            triangles,
            points,
            screen,
            face,
            scale * weights_at(planes[face], column, row),
            gradient,
        )


@wp.func
def screen_rate(points: wp.array[wp.vec3d], camera: Pinhole, vertex: wp.int32, normal: wp.vec2d):
    """Return the derivative of a vertex's image position along a normal by its position."""
    p = points[vertex]
    inverse = wp.float64(1.0) / p[2]
    across = normal[0] * camera.fx * inverse
    down = normal[1] * camera.fy * inverse
    return wp.vec3d(across, down, -(across * p[0] + down * p[1]) * inverse)


@wp.func
def depth_behind(open_fraction: wp.float64, behind: wp.float64, background: wp.float64):
    """Return the mean z [m] behind a segment of outline."""
    if wp.isnan(behind):
        return background
    return open_fraction * background + (wp.float64(1.0) - open_fraction) * behind


@wp.func
def pull_to_ends(
    scale: wp.float64,
    fraction: wp.float64,
    normal: wp.vec2d,
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    a: wp.int32,
    b: wp.int32,
    gradient: wp.array[wp.vec3d],
):
    """Pull a weight of the outward motion of a point on an edge back to the ends of that."""
    rest = wp.float64(1.0) - fraction
    wp.atomic_add(gradient, a, (scale * rest) * screen_rate(points, camera, a, normal))
    wp.atomic_add(gradient, b, (scale * fraction) * screen_rate(points, camera, b, normal))


@wp.func
def weights_of_pixel(plane: Plane, window: Window, pixel: wp.int32):
    """Return the weights of a triangle's corners at the centre of a window's pixel."""
    column = wp.float64(window.left + pixel % window.width)
    row = wp.float64(window.top + pixel // window.width)
    return weights_at(plane, column, row)


@wp.func
def pixel_of(window: Window, here: wp.vec3d):
    """Return the window's pixel that holds the middle of a segment, or is next to it.

    At the border of the image that middle may lie outside while a part of the segment is seen.
    """
    column = wp.clamp(cell_of(here[0]) - window.left, 0, window.width - 1)
    row = wp.clamp(cell_of(here[1]) - window.top, 0, window.height - 1)
    return row * window.width + column


@wp.kernel(enable_backward=False)
def pull_back_outline(
    # In:
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    window: Window,
    edges: wp.array2d[wp.int32],
    segment_edges: wp.array[wp.int32],
    segment_fractions: wp.array[wp.float64],
    segment_points: wp.array[wp.vec3d],
    segment_normals: wp.array[wp.vec2d],
    segment_lengths: wp.array[wp.float64],
    segment_open: wp.array[wp.float64],
    segment_behind: wp.array[wp.float64],
    background: wp.float64,
    by_image: wp.array[wp.float64],
    # Out:
    gradient: wp.array[wp.vec3d],
):
    """Pull the area swept by the outline back to the ends of its edges."""
    segment = wp.tid()
    length = segment_lengths[segment]
    if length <= wp.float64(0.0):
        return
    here = segment_points[segment]
    pixel = pixel_of(window, here)
    behind = depth_behind(segment_open[segment], segment_behind[segment], background)
    scale = by_image[pixel] * (here[2] - behind) * length
    edge = segment_edges[segment]
    fraction = segment_fractions[segment]
    normal = segment_normals[segment]
    pull_to_ends(scale, fraction, normal, points, camera, edges[edge, 0], edges[edge, 1], gradient)


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
def push_parts(
    # In:
    triangles: wp.array2d[wp.int32],
    points: wp.array[wp.vec3d],
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    pixels: wp.array[wp.int32],  # (M,)
    part_faces: wp.array2d[wp.int32],
    part_sums: wp.array2d[wp.vec3d],
    tangents: wp.array2d[wp.vec3d],
    # Out:
    rates: wp.array2d[wp.float64],  # (window pixels, k), accumulated
):
    """Push tangents to the inside of the area-averaged pixels."""
    index = wp.tid()
    for part in range(part_faces.shape[1]):
        face = part_faces[index, part]
        if face < 0:
            continue
        area = part_sums[index, part][0]
        column = part_sums[index, part][1] / area
        row = part_sums[index, part][2] / area
        nearness = inverse_depth_at(planes[face], column, row)
        scale = area / (nearness * nearness)
        weights = weights_at(planes[face], column, row)
        m = plane_vector(triangles, points, face)
        for parameter in range(tangents.shape[1]):
            rates[pixels[index], parameter] += scale * pushed(
                triangles, screen, tangents, face, weights, m, parameter
            )


@wp.kernel(enable_backward=False)
def push_outline_area(
    # In:
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    window: Window,
    edges: wp.array2d[wp.int32],
    segment_edges: wp.array[wp.int32],
    segment_fractions: wp.array[wp.float64],
    segment_points: wp.array[wp.vec3d],
    segment_normals: wp.array[wp.vec2d],
    segment_lengths: wp.array[wp.float64],
    segment_open: wp.array[wp.float64],
    segment_behind: wp.array[wp.float64],
    background: wp.float64,
    tangents: wp.array2d[wp.vec3d],
    # Out:
    rates: wp.array2d[wp.float64],  # (window pixels, k), accumulated
):
    """Push tangents to the area that the outline sweeps in each pixel."""
    segment = wp.tid()
    length = segment_lengths[segment]
    if length <= wp.float64(0.0):
        return
    here = segment_points[segment]
    pixel = pixel_of(window, here)
    behind = depth_behind(segment_open[segment], segment_behind[segment], background)
    scale = (here[2] - behind) * length
    edge = segment_edges[segment]
    fraction = segment_fractions[segment]
    normal = segment_normals[segment]
    a = edges[edge, 0]
    b = edges[edge, 1]
    at_a = (wp.float64(1.0) - fraction) * screen_rate(points, camera, a, normal)
    at_b = fraction * screen_rate(points, camera, b, normal)
    for parameter in range(tangents.shape[1]):
        moved = wp.dot(at_a, tangents[a, parameter]) + wp.dot(at_b, tangents[b, parameter])
        wp.atomic_add(rates, pixel, parameter, scale * moved)


@wp.kernel(enable_backward=False)
def push_outline(
    # In:
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    edges: wp.array2d[wp.int32],
    segment_edges: wp.array[wp.int32],
    segment_fractions: wp.array[wp.float64],
    segment_normals: wp.array[wp.vec2d],
    segments: wp.array[wp.int32],  # (M,)
    tangents: wp.array2d[wp.vec3d],
    # Out:
    rates: wp.array2d[wp.float64],  # (M, k) outward motion of the outline [px]
):
    """Push tangents to the outline's motion along its normal."""
    index = wp.tid()
    segment = segments[index]
    edge = segment_edges[segment]
    fraction = segment_fractions[segment]
    normal = segment_normals[segment]
    a = edges[edge, 0]
    b = edges[edge, 1]
    at_a = (wp.float64(1.0) - fraction) * screen_rate(points, camera, a, normal)
    at_b = fraction * screen_rate(points, camera, b, normal)
    for parameter in range(tangents.shape[1]):
        rates[index, parameter] = wp.dot(at_a, tangents[a, parameter]) + wp.dot(
            at_b, tangents[b, parameter]
        )
