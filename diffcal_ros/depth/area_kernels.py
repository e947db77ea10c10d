# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels that average the pixels on an outline over their area.

A pixel that an outline crosses shows body and background in shares that move with the body: only
its area average has a derivative. The other pixels are sampled at their centres.
"""

from diffcal_ros.depth.raster_kernels import (
    inverse_depth_at,
    is_in_window,
    nearest_face,
    Plane,
    tile_span,
    Tiles,
    touches_pixel,
    weights_at,
    Window,
)
from diffcal_ros.depth.silhouette_kernels import cell_of
from diffcal_ros.depth.silhouette_segments import Segments
import warp as wp

wp.set_module_options({'enable_backward': False})

# Triangles that are told apart within one pixel; beyond so many they are smaller than its samples.
PARTS = wp.constant(24)
FaceList = wp.types.vector(length=24, dtype=wp.int32)
CROWDED = wp.constant(-2)


@wp.kernel(enable_backward=False)
def list_crossings(
    # In:
    segments: Segments,
    window: Window,
    # Out:
    marks: wp.array[wp.int32],  # (window pixels,) 1 where a visible segment crosses
    crossings: wp.array[wp.int32],  # (window pixels,) segments in the pixel, hidden ones included
    last_segment: wp.array[wp.int32],  # (window pixels,) a visible one of them
):
    """Count the segments in every pixel."""
    segment = wp.tid()
    column = cell_of(segments.points[segment][0])
    row = cell_of(segments.points[segment][1])
    if is_in_window(window, column, row):
        pixel = (row - window.top) * window.width + column - window.left
        wp.atomic_add(crossings, pixel, 1)
        if segments.lengths[segment] > wp.float64(0.0):
            marks[pixel] = 1
            last_segment[pixel] = segment


@wp.func
def corner_of_pixel(corner: wp.int32):
    """Return a corner of the unit square around 0, in order around it."""
    half = wp.float64(0.5)
    turn = corner % 4
    across = wp.where(turn == 1 or turn == 2, half, -half)
    down = wp.where(turn >= 2, half, -half)
    return wp.vec2d(across, down)


@wp.func
def area_behind_line(normal: wp.vec2d, offset: wp.float64):
    """Cut the unit square around 0 by a line.

    Returns (area, area times centre) of the part where normal . x < offset.
    """
    zero = wp.float64(0.0)
    sums = wp.vec3d()
    first = wp.vec2d()
    before = wp.vec2d()
    corner_count = wp.int32(0)
    for side in range(4):
        start = corner_of_pixel(side)
        end = corner_of_pixel(side + 1)
        at_start = wp.dot(normal, start) - offset
        at_end = wp.dot(normal, end) - offset
        for half_step in range(2):
            is_corner = wp.bool(False)
            here = start
            if half_step == 0:
                is_corner = at_start < zero
            else:
                is_corner = (at_start < zero) != (at_end < zero)
                if is_corner:
                    here = start + (at_start / (at_start - at_end)) * (end - start)
            if is_corner:
                if corner_count == 0:
                    first = here
                elif corner_count > 1:
                    # A fan of triangles around the first corner.
                    a = before - first
                    b = here - first
                    area = wp.float64(0.5) * (a[0] * b[1] - a[1] * b[0])
                    centre = (first + before + here) / wp.float64(3.0)
                    sums += wp.vec3d(area, area * centre[0], area * centre[1])
                before = here
                corner_count += 1
    return sums


@wp.kernel(enable_backward=False)
def cut_pixels(
    # In:
    planes: wp.array[Plane],
    window: Window,
    pixels: wp.array[wp.int32],  # (M,) window pixels that one straight segment crosses
    last_segment: wp.array[wp.int32],  # (window pixels,)
    segments: Segments,
    background: wp.float64,
    # Out:
    part_faces: wp.array2d[wp.int32],  # (M, 2) triangle in front and behind, -1 for none or uncut
    part_sums: wp.array2d[wp.vec3d],  # (M, 2) area, area times column, area times row
    image: wp.array[wp.float64],  # (window pixels,)
    is_cut: wp.array[wp.int32],  # (M,) 1 where one triangle is seen on each side of the outline
):
    """Replace pixels with one triangle on each side of the outline by their exact average."""
    index = wp.tid()
    pixel = pixels[index]
    segment = last_segment[pixel]
    one = wp.float64(1.0)
    column = wp.float64(window.left + pixel % window.width)
    row = wp.float64(window.top + pixel // window.width)
    point = segments.points[segment]
    normal = segments.normals[segment]
    offset = normal[0] * (point[0] - column) + normal[1] * (point[1] - row)
    inside = area_behind_line(normal, offset)
    part_faces[index, 0] = -1
    part_faces[index, 1] = -1
    total = wp.float64(0.0)
    for part in range(2):
        sums = inside
        if part == 1:
            sums = wp.vec3d(one - inside[0], -inside[1], -inside[2])
        if sums[0] < wp.float64(1.0e-12):
            continue
        there = wp.vec2d(column + sums[1] / sums[0], row + sums[2] / sums[0])
        face = segments.faces[segment, part]
        # Another triangle at the part's centre: the pixel shows more than two.
        outside = wp.bool(False)
        if face >= 0:
            outside = wp.min(weights_at(planes[face], there[0], there[1])) < wp.float64(-1.0e-9)
        if outside:
            part_faces[index, 0] = -1
            return
        part_faces[index, part] = face
        part_sums[index, part] = sums[0] * wp.vec3d(one, there[0], there[1])
        if face < 0:
            total += sums[0] * background
        else:
            total += sums[0] / inverse_depth_at(planes[face], there[0], there[1])
    is_cut[index] = 1
    image[pixel] = total


@wp.func
def sample_point(sample: wp.int32, side: wp.int32):
    """Return a sample's place in the unit square.

    The square lattice is sheared both ways, so that upright and level edges pass its points a
    few at a time.
    """
    half = wp.float64(0.5)
    step = wp.float64(1.0) / wp.float64(side)
    i = wp.float64(sample % side)
    j = wp.float64(sample // side)
    return wp.vec2d((i + (j + half) * step) * step, (j + (i + half) * step) * step)


@wp.func
def touching_faces(
    triangles: wp.array2d[wp.int32],
    screen: wp.array[wp.vec3d],
    tiles: Tiles,
    column: wp.float64,
    row: wp.float64,
):
    """List the triangles that reach into a pixel, -1 after the last."""
    half = wp.float64(0.5)
    found = FaceList()
    for index in range(PARTS):
        found[index] = -1
    count = wp.int32(0)
    members = tile_span(tiles, column, row)
    for member in range(members[0], members[1]):
        face = tiles.members[member]
        a = screen[triangles[face, 0]]
        b = screen[triangles[face, 1]]
        c = screen[triangles[face, 2]]
        low = wp.min(wp.min(a, b), c)
        high = wp.max(wp.max(a, b), c)
        # The box as well: the sides alone do not tell where a sliver ends.
        reaches = (
            low[0] <= column + half
            and high[0] >= column - half
            and low[1] <= row + half
            and high[1] >= row - half
        )
        if reaches and touches_pixel(tiles.planes[face], column, row):
            if count < PARTS:
                found[count] = face
            count += 1
    if count > PARTS:
        found[0] = CROWDED
    return found


@wp.func
def place_of(faces: FaceList, face: wp.int32):
    """Return the place of a triangle in a list, or of the first free one, or the last."""
    for part in range(PARTS):
        if faces[part] == face or faces[part] < 0:
            return part
    return PARTS - 1


@wp.func
def nearest_part(
    faces: FaceList,
    planes: wp.array[Plane],
    column: wp.float64,
    row: wp.float64,
):
    """Return the place in a list of the triangle that is seen at a point, -1 for none."""
    nearest = wp.float64(0.0)
    found = wp.int32(-1)
    for part in range(PARTS):
        face = faces[part]
        if face < 0:
            break
        plane = planes[face]
        if wp.min(weights_at(plane, column, row)) >= wp.float64(0.0):
            near = inverse_depth_at(plane, column, row)
            if near > nearest:
                nearest = near
                found = part
    return found


@wp.kernel(enable_backward=False)
def sample_pixels(
    # In:
    triangles: wp.array2d[wp.int32],
    screen: wp.array[wp.vec3d],
    tiles: Tiles,
    pixels: wp.array[wp.int32],  # (M,) window pixels to sample
    side: wp.int32,  # samples along each side of a pixel
    background: wp.float64,  # value where nothing is seen
    # Out:
    part_faces: wp.array2d[wp.int32],  # (M, PARTS) triangles in the pixel, -1 for none seen
    part_sums: wp.array2d[wp.vec3d],  # (M, PARTS) area, area times column, area times row
    image: wp.array[wp.float64],  # (window pixels,) mean of the samples
):
    """Replace pixels where the outline turns or ends by the mean of side x side samples.

    The samples that one triangle owns are kept as a count and a centre: z is so nearly linear
    within a pixel that its derivative may be taken there.
    """
    index = wp.tid()
    pixel = pixels[index]
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    half = wp.float64(0.5)
    window = tiles.window
    left = wp.float64(window.left + pixel % window.width) - half
    top = wp.float64(window.top + pixel // window.width) - half
    faces = touching_faces(triangles, screen, tiles, left + half, top + half)
    is_crowded = faces[0] == CROWDED
    if is_crowded:
        # More triangles than parts: look at all of the tile's, and give the rest to the last.
        for part in range(PARTS):
            faces[part] = -1
    fraction = one / wp.float64(side * side)
    total = zero
    for sample in range(side * side):
        here = sample_point(sample, side)
        column = left + here[0]
        row = top + here[1]
        owner = wp.int32(-1)
        seen = wp.int32(-1)
        if is_crowded:
            seen = nearest_face(tiles, column, row)
            if seen >= 0:
                owner = place_of(faces, seen)
                faces[owner] = seen
        else:
            owner = nearest_part(faces, tiles.planes, column, row)
            if owner >= 0:
                seen = faces[owner]
        if seen < 0:
            total += background
        else:
            total += one / inverse_depth_at(tiles.planes[seen], column, row)
            part_sums[index, owner] += fraction * wp.vec3d(one, column, row)
    for part in range(PARTS):
        part_faces[index, part] = wp.where(part_sums[index, part][0] > zero, faces[part], -1)
    image[pixel] = total * fraction
