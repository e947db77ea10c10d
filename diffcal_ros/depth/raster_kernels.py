# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels that turn triangles into a depth image: z-buffer, tiles, rays.

Image coordinates are (column, row) with pixel centres at integers; `screen` holds
(column, row, 1/z) of each vertex, because 1/z is linear in the image.
"""

import warp as wp

wp.set_module_options({'enable_backward': False})

EMPTY = wp.constant(wp.int64(-1))
TILE = wp.constant(16)
# Slack at the border of a triangle [px], so that no pixel centre falls between two neighbours.
_SLACK = wp.constant(wp.float64(1.0e-7))
_NO_LIMIT = wp.constant(wp.float64(1.0e9))


@wp.struct
class Window:
    """The part of the image that the body covers."""

    left: wp.int32
    top: wp.int32
    width: wp.int32
    height: wp.int32


@wp.struct
class Plane:
    """A triangle in the image; each vector gives (constant, per column, per row).

    The first two image barycentric coordinates and 1/z [1/m]; all are linear in the image.
    """

    first: wp.vec3d
    second: wp.vec3d
    inverse_depth: wp.vec3d
    is_front: wp.bool


@wp.func
def twice_area(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d):
    """Return twice the signed image area; negative faces the camera (rows run down)."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


@wp.func
def opposite(b: wp.vec3d, c: wp.vec3d, scale: wp.float64):
    """Return the barycentric coordinate that vanishes on the side from b to c."""
    return wp.vec3d(
        scale * (b[0] * c[1] - b[1] * c[0]), scale * (b[1] - c[1]), scale * (c[0] - b[0])
    )


@wp.kernel(enable_backward=False)
def make_planes(
    # In:
    triangles: wp.array2d[wp.int32],  # (F, 3)
    screen: wp.array[wp.vec3d],  # (N,) [px, px, 1/m]
    # Out:
    planes: wp.array[Plane],  # (F,)
):
    """Prepare each triangle for sampling."""
    face = wp.tid()
    a = screen[triangles[face, 0]]
    b = screen[triangles[face, 1]]
    c = screen[triangles[face, 2]]
    area = twice_area(a, b, c)
    plane = Plane()
    plane.is_front = area < wp.float64(0.0)
    if plane.is_front:
        scale = wp.float64(1.0) / area
        plane.first = opposite(b, c, scale)
        plane.second = opposite(c, a, scale)
        plane.inverse_depth = (
            a[2] * plane.first + b[2] * plane.second + c[2] * opposite(a, b, scale)
        )
    planes[face] = plane


@wp.func
def weights_at(plane: Plane, column: wp.float64, row: wp.float64):
    """Return image barycentric coordinates; all are non-negative inside."""
    here = wp.vec3d(wp.float64(1.0), column, row)
    first = wp.dot(plane.first, here)
    second = wp.dot(plane.second, here)
    return wp.vec3d(first, second, wp.float64(1.0) - first - second)


@wp.func
def inverse_depth_at(plane: Plane, column: wp.float64, row: wp.float64):
    """Return 1/z [1/m] of the triangle's plane."""
    return wp.dot(plane.inverse_depth, wp.vec3d(wp.float64(1.0), column, row))


@wp.func
def touches_pixel(plane: Plane, column: wp.float64, row: wp.float64):
    """Tell whether a triangle can reach into a pixel (it may still pass by a corner)."""
    half = wp.float64(0.5)
    weights = weights_at(plane, column, row)
    third_column = plane.first[1] + plane.second[1]
    third_row = plane.first[2] + plane.second[2]
    return (
        weights[0] + half * (wp.abs(plane.first[1]) + wp.abs(plane.first[2])) >= wp.float64(0.0)
        and weights[1] + half * (wp.abs(plane.second[1]) + wp.abs(plane.second[2]))
        >= wp.float64(0.0)
        and weights[2] + half * (wp.abs(third_column) + wp.abs(third_row)) >= wp.float64(0.0)
    )


@wp.func
def narrowed(span: wp.vec2d, value: wp.float64, per_column: wp.float64):
    """Cut a span of columns to where value + per_column * column is not negative."""
    zero = wp.float64(0.0)
    if per_column > zero:
        return wp.vec2d(wp.max(span[0], -value / per_column), span[1])
    if per_column < zero:
        return wp.vec2d(span[0], wp.min(span[1], -value / per_column))
    if value < zero:
        return wp.vec2d(_NO_LIMIT, -_NO_LIMIT)
    return span


@wp.func
def columns_inside(plane: Plane, row: wp.float64):
    """Return first and last column of a triangle in one row, a hair more than exact."""
    one = wp.float64(1.0)
    first = plane.first[0] + plane.first[2] * row
    second = plane.second[0] + plane.second[2] * row
    span = wp.vec2d(-_NO_LIMIT, _NO_LIMIT)
    span = narrowed(span, first, plane.first[1])
    span = narrowed(span, second, plane.second[1])
    span = narrowed(span, one - first - second, -plane.first[1] - plane.second[1])
    return wp.vec2d(span[0] - _SLACK, span[1] + _SLACK)


@wp.func
def is_in_window(window: Window, column: wp.int32, row: wp.int32):
    """Tell whether a pixel belongs to the window."""
    return (
        column >= window.left
        and row >= window.top
        and column < window.left + window.width
        and row < window.top + window.height
    )


@wp.func
def rows_of(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, window: Window):
    """Return first and last row of the window that a triangle may cover."""
    low = wp.min(wp.min(a[1], b[1]), c[1])
    high = wp.max(wp.max(a[1], b[1]), c[1])
    return wp.vec2i(
        wp.max(wp.int32(wp.ceil(low - _SLACK)), window.top),
        wp.min(wp.int32(wp.floor(high + _SLACK)), window.top + window.height - 1),
    )


@wp.func
def columns_of(plane: Plane, row: wp.int32, window: Window):
    """Return first and last column of the window whose centres in a row a triangle covers."""
    span = columns_inside(plane, wp.float64(row))
    return wp.vec2i(
        wp.max(wp.int32(wp.ceil(span[0])), window.left),
        wp.min(wp.int32(wp.floor(span[1])), window.left + window.width - 1),
    )


@wp.kernel(enable_backward=False)
def rasterise(
    # In:
    triangles: wp.array2d[wp.int32],
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    window: Window,
    depth_steps: wp.float64,  # 1/z times this fits 31 bits
    # Out:
    keys: wp.array[wp.int64],  # (window pixels,) nearest 1/z and its triangle
):
    """Keep the nearest front-facing triangle of every pixel centre.

    1/z is packed above the triangle's number, so that one atomic maximum settles both.
    """
    face = wp.tid()
    plane = planes[face]
    if not plane.is_front:
        return
    rows = rows_of(
        screen[triangles[face, 0]], screen[triangles[face, 1]], screen[triangles[face, 2]], window
    )
    for row in range(rows[0], rows[1] + 1):
        columns = columns_of(plane, row, window)
        start = (row - window.top) * window.width - window.left
        for column in range(columns[0], columns[1] + 1):
            nearness = inverse_depth_at(plane, wp.float64(column), wp.float64(row))
            key = (wp.int64(nearness * depth_steps) << wp.int64(32)) | wp.int64(face)
            wp.atomic_max(keys, start + column, key)


@wp.kernel(enable_backward=False)
def resolve(
    # In:
    planes: wp.array[Plane],
    window: Window,
    # In and out:
    keys: wp.array[wp.int64],  # emptied for the next image
    # Out:
    faces: wp.array[wp.int32],  # (window pixels,) triangle seen, or -1
    depth: wp.array[wp.float64],  # (window pixels,) z [m], NaN where nothing is seen
):
    """Turn the z-buffer into triangle numbers and exact depths."""
    pixel = wp.tid()
    key = keys[pixel]
    if key == EMPTY:
        faces[pixel] = -1
        depth[pixel] = wp.float64(wp.nan)
        return
    keys[pixel] = EMPTY
    face = wp.int32(key & wp.int64(0x7FFFFFFF))
    column = wp.float64(window.left + pixel % window.width)
    row = wp.float64(window.top + pixel // window.width)
    faces[pixel] = face
    depth[pixel] = wp.float64(1.0) / inverse_depth_at(planes[face], column, row)


@wp.func
def tile_range(a: wp.vec3d, b: wp.vec3d, c: wp.vec3d, window: Window):
    """Return first and last tile column and row that a triangle's box touches."""
    low = wp.min(wp.min(a, b), c)
    high = wp.max(wp.max(a, b), c)
    columns = (window.width + TILE - 1) // TILE
    rows = (window.height + TILE - 1) // TILE
    # Pixels reach half a step beyond their centres.
    return wp.vec4i(
        wp.clamp((wp.int32(wp.floor(low[0])) - window.left) // TILE, 0, columns - 1),
        wp.clamp((wp.int32(wp.ceil(high[0])) - window.left) // TILE, 0, columns - 1),
        wp.clamp((wp.int32(wp.floor(low[1])) - window.top) // TILE, 0, rows - 1),
        wp.clamp((wp.int32(wp.ceil(high[1])) - window.top) // TILE, 0, rows - 1),
    )


@wp.kernel(enable_backward=False)
def count_tiles(
    # In:
    triangles: wp.array2d[wp.int32],
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    window: Window,
    # Out:
    counts: wp.array[wp.int32],  # (tiles,), accumulated
):
    """Count the front-facing triangles that touch each tile."""
    face = wp.tid()
    if not planes[face].is_front:
        return
    span = tile_range(
        screen[triangles[face, 0]], screen[triangles[face, 1]], screen[triangles[face, 2]], window
    )
    columns = (window.width + TILE - 1) // TILE
    for row in range(span[2], span[3] + 1):
        for column in range(span[0], span[1] + 1):
            wp.atomic_add(counts, row * columns + column, 1)


@wp.kernel(enable_backward=False)
def fill_tiles(
    # In:
    triangles: wp.array2d[wp.int32],
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    window: Window,
    ends: wp.array[wp.int32],  # (tiles,) inclusive sums of the counts
    # In and out:
    counts: wp.array[wp.int32],  # (tiles,), counted down to zero
    # Out:
    members: wp.array[wp.int32],  # triangles, tile by tile
):
    """List the front-facing triangles of each tile."""
    face = wp.tid()
    if not planes[face].is_front:
        return
    span = tile_range(
        screen[triangles[face, 0]], screen[triangles[face, 1]], screen[triangles[face, 2]], window
    )
    columns = (window.width + TILE - 1) // TILE
    for row in range(span[2], span[3] + 1):
        for column in range(span[0], span[1] + 1):
            tile = row * columns + column
            left = wp.atomic_sub(counts, tile, 1)
            members[ends[tile] - left] = face


@wp.struct
class Tiles:
    """Squares of the window, each with a list of the triangles that may be seen in it.

    Attributes:
        window: of the image.
        planes: all triangles, shape (F,).
        ends: of each tile's list, inclusive sums of their lengths, shape (tiles,).
        members: triangles, tile by tile.
    """

    window: Window
    planes: wp.array[Plane]
    ends: wp.array[wp.int32]
    members: wp.array[wp.int32]


@wp.func
def tile_span(tiles: Tiles, column: wp.float64, row: wp.float64):
    """Return first and end of the members of the tile that holds an image point."""
    window = tiles.window
    columns = (window.width + TILE - 1) // TILE
    rows = (window.height + TILE - 1) // TILE
    tile_column = wp.clamp((wp.int32(wp.floor(column)) - window.left) // TILE, 0, columns - 1)
    tile_row = wp.clamp((wp.int32(wp.floor(row)) - window.top) // TILE, 0, rows - 1)
    tile = tile_row * columns + tile_column
    first = wp.int32(0)
    if tile > 0:
        first = tiles.ends[tile - 1]
    return wp.vec2i(first, tiles.ends[tile])


@wp.func
def nearest_face(tiles: Tiles, column: wp.float64, row: wp.float64):
    """Return the front-facing triangle seen at any image point, or -1."""
    zero = wp.float64(0.0)
    nearest = zero
    found = wp.int32(-1)
    span = tile_span(tiles, column, row)
    for index in range(span[0], span[1]):
        face = tiles.members[index]
        plane = tiles.planes[face]
        weights = weights_at(plane, column, row)
        if weights[0] >= zero and weights[1] >= zero and weights[2] >= zero:
            here = inverse_depth_at(plane, column, row)
            if here > nearest:
                nearest = here
                found = face
    return found
