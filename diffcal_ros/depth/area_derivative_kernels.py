# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels for the derivative of an image whose outline is averaged over its pixels.

See `derivative_kernels`. At a visible outline a pixel's mean changes by (z in front - z behind)
times the area that the outline sweeps (Arnavaz et al. 2023, equations 7 and 8).
"""

from diffcal_ros.depth.derivative_kernels import (
    add_to_corners,
    end_rates,
    motion_of,
    Pinhole,
    plane_vector,
    pull_to_ends,
    pushed,
)
from diffcal_ros.depth.raster_kernels import (
    columns_of,
    inverse_depth_at,
    Plane,
    rows_of,
    weights_at,
    Window,
)
from diffcal_ros.depth.silhouette_kernels import cell_of
from diffcal_ros.depth.silhouette_segments import Segments
import warp as wp

wp.set_module_options({'enable_backward': False})


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
        columns = columns_of(plane, row, window)
        start = (row - window.top) * window.width - window.left
        for column in range(columns[0], columns[1] + 1):
            pixel = start + column
            if faces[pixel] == face and marks[pixel] == 0:
                x = wp.float64(column)
                near = inverse_depth_at(plane, x, y)
                sums += (by_image[pixel] / (near * near)) * weights_at(plane, x, y)
    add_to_corners(triangles, points, screen, face, sums, gradient)


@wp.func
def weights_of_part(plane: Plane, sums: wp.vec3d):
    """Return area times z^2 times the weights of a triangle's corners at a part's centre."""
    column = sums[1] / sums[0]
    row = sums[2] / sums[0]
    nearness = inverse_depth_at(plane, column, row)
    return (sums[0] / (nearness * nearness)) * weights_at(plane, column, row)


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
        weights = by_image[pixels[index]] * weights_of_part(planes[face], part_sums[index, part])
        add_to_corners(triangles, points, screen, face, weights, gradient)


@wp.func
def depth_behind(open_fraction: wp.float64, behind: wp.float64, background: wp.float64):
    """Return the mean z [m] behind a segment of outline."""
    if wp.isnan(behind):
        return background
    return open_fraction * background + (wp.float64(1.0) - open_fraction) * behind


@wp.func
def swept(segments: Segments, segment: wp.int32, background: wp.float64):
    """Return by how much depth summed over pixels falls per outward motion of a segment [m]."""
    behind = depth_behind(segments.open[segment], segments.behind[segment], background)
    return (segments.points[segment][2] - behind) * segments.lengths[segment]


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
    segments: Segments,
    background: wp.float64,
    by_image: wp.array[wp.float64],
    # Out:
    gradient: wp.array[wp.vec3d],
):
    """Pull the area swept by the outline back to the ends of its edges."""
    segment = wp.tid()
    if segments.lengths[segment] <= wp.float64(0.0):
        return
    pixel = pixel_of(window, segments.points[segment])
    scale = by_image[pixel] * swept(segments, segment, background)
    pull_to_ends(scale, segments, segment, points, camera, edges, gradient)


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
        weights = weights_of_part(planes[face], part_sums[index, part])
        m = plane_vector(triangles, points, face)
        for parameter in range(tangents.shape[1]):
            rates[pixels[index], parameter] += pushed(
                triangles, screen, tangents, face, weights, m, parameter
            )


@wp.kernel(enable_backward=False)
def push_outline_area(
    # In:
    points: wp.array[wp.vec3d],
    camera: Pinhole,
    window: Window,
    edges: wp.array2d[wp.int32],
    segments: Segments,
    background: wp.float64,
    tangents: wp.array2d[wp.vec3d],
    # Out:
    rates: wp.array2d[wp.float64],  # (window pixels, k), accumulated
):
    """Push tangents to the area that the outline sweeps in each pixel."""
    segment = wp.tid()
    if segments.lengths[segment] <= wp.float64(0.0):
        return
    pixel = pixel_of(window, segments.points[segment])
    scale = swept(segments, segment, background)
    ends = end_rates(segments, segment, points, camera, edges)
    for parameter in range(tangents.shape[1]):
        wp.atomic_add(rates, pixel, parameter, scale * motion_of(ends, tangents, parameter))
