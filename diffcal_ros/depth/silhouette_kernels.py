# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels that walk silhouette edges through the pixel grid.

A silhouette edge lies between a triangle that faces the camera and one that does not. It is cut
at the borders of the pixels it crosses; each segment gets one node in its middle and one ray just
outside the body, which tells whether the segment is visible and what lies behind it
(Arnavaz et al. 2023, equation 8, integrated segment by segment).
"""

from diffcal_ros.depth.raster_kernels import (
    inverse_depth_at,
    is_in_window,
    nearest_face,
    Plane,
    Tiles,
    Window,
)
from diffcal_ros.depth.silhouette_segments import Segments
import warp as wp

wp.set_module_options({'enable_backward': False})

# How far outside the outline the ray passes [px]: well under a pixel, well over rounding.
_OUTSIDE = wp.constant(wp.float64(1.0e-3))


@wp.func
def cell_of(coordinate: wp.float64):
    """Return the pixel whose square holds a coordinate."""
    return wp.int32(wp.floor(coordinate + wp.float64(0.5)))


@wp.func
def seen_side(planes: wp.array[Plane], edge_faces: wp.array2d[wp.int32], edge: wp.int32):
    """Return which of the two faces of an edge is seen: 0, 1, or -1 for no silhouette."""
    first_seen = planes[edge_faces[edge, 0]].is_front
    second_seen = wp.bool(False)
    if edge_faces[edge, 1] >= 0:
        second_seen = planes[edge_faces[edge, 1]].is_front
    if first_seen == second_seen:
        return -1
    if first_seen:
        return 0
    return 1


@wp.func
def is_beside(window: Window, a: wp.vec3d, b: wp.vec3d):
    """Tell whether an edge surely misses the window."""
    one = wp.float64(1.0)
    low = wp.min(a, b)
    high = wp.max(a, b)
    return (
        high[0] < wp.float64(window.left) - one
        or low[0] > wp.float64(window.left + window.width)
        or high[1] < wp.float64(window.top) - one
        or low[1] > wp.float64(window.top + window.height)
    )


@wp.kernel(enable_backward=False)
def count_segments(
    # In:
    screen: wp.array[wp.vec3d],  # (N,) [px, px, 1/m]
    planes: wp.array[Plane],  # (F,)
    edges: wp.array2d[wp.int32],  # (E, 2) vertices
    edge_faces: wp.array2d[wp.int32],  # (E, 2) triangles, -1 for none
    window: Window,
    # Out:
    counts: wp.array[wp.int32],  # (E,)
):
    """Count the pixels that each silhouette edge crosses."""
    edge = wp.tid()
    counts[edge] = 0
    if seen_side(planes, edge_faces, edge) < 0:
        return
    a = screen[edges[edge, 0]]
    b = screen[edges[edge, 1]]
    if is_beside(window, a, b):
        return
    counts[edge] = (
        1 + wp.abs(cell_of(a[0]) - cell_of(b[0])) + wp.abs(cell_of(a[1]) - cell_of(b[1]))
    )


@wp.func
def next_crossing(start: wp.float64, rate: wp.float64, cell: wp.int32):
    """Return at which share of an edge it leaves the pixel along one axis."""
    half = wp.float64(0.5)
    if rate > wp.float64(0.0):
        return (wp.float64(cell) + half - start) / rate
    if rate < wp.float64(0.0):
        return (wp.float64(cell) - half - start) / rate
    return wp.float64(2.0)


@wp.struct
class Edge:
    """A silhouette edge in the image.

    Attributes:
        a: one end: column, row [px] and 1/z [1/m]; `b` the other.
        along: from the one to the other [px].
        length: of that [px].
        normal: unit, pointing out of the body.
        face: the triangle on the side that is seen.
    """

    a: wp.vec3d
    b: wp.vec3d
    along: wp.vec2d
    length: wp.float64
    normal: wp.vec2d
    face: wp.int32


@wp.struct
class Visibility:
    """What one ray just outside an edge sees.

    Attributes are whether the edge is visible there, the triangle behind it (-1 for none) and
    that triangle's z [m].
    """

    is_visible: wp.bool
    face: wp.int32
    behind: wp.float64


@wp.struct
class Sums:
    """Lengths of one segment [px]: visible, with nothing behind; length times z behind [px m]."""

    visible: wp.float64
    open: wp.float64
    behind: wp.float64


@wp.func
def depth_on(edge: Edge, fraction: wp.float64):
    """Return z [m] at a place of an edge."""
    return wp.float64(1.0) / (edge.a[2] + fraction * (edge.b[2] - edge.a[2]))


@wp.func
def point_on(edge: Edge, fraction: wp.float64):
    """Return column, row [px] and z [m] at a place of an edge."""
    return wp.vec3d(
        edge.a[0] + fraction * edge.along[0],
        edge.a[1] + fraction * edge.along[1],
        depth_on(edge, fraction),
    )


@wp.func
def visibility_at(edge: Edge, fraction: wp.float64, tiles: Tiles):
    """Cast a ray just outside a point of an edge."""
    one = wp.float64(1.0)
    result = Visibility()
    here = edge.a + fraction * (edge.b - edge.a)
    result.is_visible = is_in_window(tiles.window, cell_of(here[0]), cell_of(here[1]))
    result.face = -1
    if result.is_visible:
        column = here[0] + _OUTSIDE * edge.normal[0]
        row = here[1] + _OUTSIDE * edge.normal[1]
        result.face = nearest_face(tiles, column, row)
        if result.face >= 0:
            nearness = inverse_depth_at(tiles.planes[result.face], column, row)
            result.behind = one / nearness
            result.is_visible = nearness <= here[2]
    return result


@wp.func
def are_alike(first: Visibility, second: Visibility, depth: wp.float64):
    """Tell whether nothing comes or goes between two places along an edge."""
    if first.is_visible != second.is_visible:
        return False
    if not first.is_visible:
        return True
    if (first.face < 0) != (second.face < 0):
        return False
    if first.face < 0:
        return True
    step = wp.abs(first.behind - second.behind)
    return step < wp.float64(0.2) * (first.behind - depth) + wp.float64(1.0e-4)


@wp.func
def added(sums: Sums, length: wp.float64, visibility: Visibility):
    """Add a stretch that looks the same all along."""
    result = sums
    if visibility.is_visible and length > wp.float64(0.0):
        result.visible = sums.visible + length
        if visibility.face < 0:
            result.open = sums.open + length
        else:
            result.behind = sums.behind + length * visibility.behind
    return result


@wp.func
def write_sums(record: wp.int32, sums: Sums, segments: Segments):
    """Turn sums into a segment's visible length, open share and mean depth behind."""
    segments.lengths[record] = sums.visible
    segments.open[record] = wp.float64(0.0)
    segments.behind[record] = wp.float64(wp.nan)
    if sums.visible > wp.float64(0.0):
        segments.open[record] = sums.open / sums.visible
        closed = sums.visible - sums.open
        if closed > wp.float64(1.0e-9) * sums.visible:
            segments.behind[record] = sums.behind / closed


@wp.func
def outward_normal(
    triangles: wp.array2d[wp.int32],
    screen: wp.array[wp.vec3d],
    face: wp.int32,
    a: wp.vec3d,
    b: wp.vec3d,
):
    """Return the unit normal of an edge in the image, away from its triangle."""
    normal = wp.vec2d(b[1] - a[1], a[0] - b[0])
    normal = normal / wp.max(wp.length(normal), wp.float64(1.0e-12))
    for corner in range(3):
        inner = screen[triangles[face, corner]]
        away = normal[0] * (inner[0] - a[0]) + normal[1] * (inner[1] - a[1])
        # The third corner is the only one off the line.
        if away > wp.float64(1.0e-9):
            normal = -normal
    return normal


@wp.func
def make_edge(
    number: wp.int32,
    triangles: wp.array2d[wp.int32],
    screen: wp.array[wp.vec3d],
    edges: wp.array2d[wp.int32],
    edge_faces: wp.array2d[wp.int32],
    planes: wp.array[Plane],
):
    """Gather what a walk along a silhouette edge needs."""
    edge = Edge()
    edge.a = screen[edges[number, 0]]
    edge.b = screen[edges[number, 1]]
    edge.face = edge_faces[number, seen_side(planes, edge_faces, number)]
    edge.along = wp.vec2d(edge.b[0] - edge.a[0], edge.b[1] - edge.a[1])
    edge.length = wp.length(edge.along)
    edge.normal = outward_normal(triangles, screen, edge.face, edge.a, edge.b)
    return edge


@wp.func
def place_of_change(
    edge: Edge,
    low: wp.float64,
    high: wp.float64,
    before: Visibility,
    after: Visibility,
    tiles: Tiles,
):
    """Bisect for where an edge stops looking as it does at `low`; `high` where it never does."""
    near = low
    far = high
    if are_alike(before, after, depth_on(edge, high)):
        return far
    for _ in range(7):
        middle = wp.float64(0.5) * (near + far)
        if are_alike(before, visibility_at(edge, middle, tiles), depth_on(edge, middle)):
            near = middle
        else:
            far = middle
    return far


@wp.func
def write_place(
    record: wp.int32,
    number: wp.int32,
    edge: Edge,
    node: wp.float64,
    behind: wp.int32,
    segments: Segments,
):
    """Write where the middle of a segment is, and which triangles are before and behind it."""
    segments.edges[record] = number
    segments.fractions[record] = node
    segments.points[record] = wp.vec3d(
        edge.a[0] + node * edge.along[0],
        edge.a[1] + node * edge.along[1],
        depth_on(edge, node),
    )
    segments.normals[record] = edge.normal
    segments.faces[record, 0] = edge.face
    segments.faces[record, 1] = behind


@wp.kernel(enable_backward=False)
def walk_edges(
    # In:
    triangles: wp.array2d[wp.int32],  # (F, 3)
    screen: wp.array[wp.vec3d],
    edges: wp.array2d[wp.int32],
    edge_faces: wp.array2d[wp.int32],
    ends: wp.array[wp.int32],  # (E,) inclusive sums of the counts
    tiles: Tiles,
    # Out:
    segments: Segments,
):
    """Write one record a segment.

    Between the nodes of neighbouring segments the view past the edge may change: where the edge
    passes behind another part of the body, or another outline passes behind it. Such segments
    count for their visible part.
    """
    number = wp.tid()
    first = wp.int32(0)
    if number > 0:
        first = ends[number - 1]
    count = ends[number] - first
    if count == 0:
        return
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    edge = make_edge(number, triangles, screen, edges, edge_faces, tiles.planes)
    column = cell_of(edge.a[0])
    row = cell_of(edge.a[1])
    border = zero
    last_node = zero
    # Not at the very ends, where the neighbouring edges take over.
    before = visibility_at(edge, wp.float64(0.01), tiles)
    sums = Sums()
    for index in range(count):
        to_column = next_crossing(edge.a[0], edge.along[0], column)
        to_row = next_crossing(edge.a[1], edge.along[1], row)
        leave = wp.clamp(wp.min(to_column, to_row), border, one)
        if index == count - 1:
            leave = one
        node = wp.float64(0.5) * (border + leave)
        after = visibility_at(edge, node, tiles)
        change = place_of_change(edge, last_node, node, before, after, tiles)
        # The stretch from the last node belongs to the last segment up to the pixels' border.
        if index > 0:
            sums = added(sums, edge.length * (wp.min(change, border) - last_node), before)
            sums = added(sums, edge.length * (border - wp.max(change, last_node)), after)
            write_sums(first + index - 1, sums, segments)
        sums = Sums()
        sums = added(sums, edge.length * (change - border), before)
        sums = added(sums, edge.length * (node - wp.max(change, border)), after)
        write_place(first + index, number, edge, node, after.face, segments)
        last_node = node
        before = after
        border = leave
        if to_column < to_row:
            column += wp.where(edge.along[0] > zero, 1, -1)
        else:
            row += wp.where(edge.along[1] > zero, 1, -1)
    after = visibility_at(edge, wp.float64(0.99), tiles)
    change = place_of_change(edge, last_node, one, before, after, tiles)
    sums = added(sums, edge.length * (change - last_node), before)
    sums = added(sums, edge.length * (one - change), after)
    write_sums(ends[number] - 1, sums, segments)


@wp.kernel(enable_backward=False)
def mark_outline(
    # In:
    segments: Segments,
    window: Window,
    reach: wp.int32,  # [px]
    # Out:
    marks: wp.array[wp.int32],  # (window pixels,) 1 within reach of a visible outline
):
    """Mark the pixels around the visible outline."""
    segment = wp.tid()
    if segments.lengths[segment] <= wp.float64(0.0):
        return
    column = cell_of(segments.points[segment][0])
    row = cell_of(segments.points[segment][1])
    for down in range(-reach, reach + 1):
        for across in range(-reach, reach + 1):
            if is_in_window(window, column + across, row + down):
                marks[(row + down - window.top) * window.width + column + across - window.left] = 1
