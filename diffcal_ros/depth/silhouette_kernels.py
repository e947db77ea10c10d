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
    Window,
)
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
def visibility_at(
    screen_a: wp.vec3d,
    screen_b: wp.vec3d,
    fraction: wp.float64,
    normal: wp.vec2d,
    planes: wp.array[Plane],
    window: Window,
    tile_ends: wp.array[wp.int32],
    tile_members: wp.array[wp.int32],
):
    """Cast a ray just outside a point of an edge."""
    one = wp.float64(1.0)
    result = Visibility()
    here = screen_a + fraction * (screen_b - screen_a)
    result.is_visible = is_in_window(window, cell_of(here[0]), cell_of(here[1]))
    result.face = -1
    if result.is_visible:
        column = here[0] + _OUTSIDE * normal[0]
        row = here[1] + _OUTSIDE * normal[1]
        result.face = nearest_face(planes, window, tile_ends, tile_members, column, row)
        if result.face >= 0:
            nearness = inverse_depth_at(planes[result.face], column, row)
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
def write_sums(
    record: wp.int32,
    sums: Sums,
    segment_lengths: wp.array[wp.float64],
    segment_open: wp.array[wp.float64],
    segment_behind: wp.array[wp.float64],
):
    """Turn sums into a segment's visible length, open share and mean depth behind."""
    segment_lengths[record] = sums.visible
    segment_open[record] = wp.float64(0.0)
    segment_behind[record] = wp.float64(wp.nan)
    if sums.visible > wp.float64(0.0):
        segment_open[record] = sums.open / sums.visible
        closed = sums.visible - sums.open
        if closed > wp.float64(1.0e-9) * sums.visible:
            segment_behind[record] = sums.behind / closed


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
def place_of_change(
    a: wp.vec3d,
    b: wp.vec3d,
    low: wp.float64,
    high: wp.float64,
    visibility: Visibility,
    normal: wp.vec2d,
    planes: wp.array[Plane],
    window: Window,
    tile_ends: wp.array[wp.int32],
    tile_members: wp.array[wp.int32],
):
    """Bisect for where an edge stops looking as it does at its share `low`."""
    one = wp.float64(1.0)
    near = low
    far = high
    for _ in range(7):
        middle = wp.float64(0.5) * (near + far)
        between = visibility_at(a, b, middle, normal, planes, window, tile_ends, tile_members)
        if are_alike(visibility, between, one / (a[2] + middle * (b[2] - a[2]))):
            near = middle
        else:
            far = middle
    return far


@wp.kernel(enable_backward=False)
def walk_edges(
    # In:
    triangles: wp.array2d[wp.int32],  # (F, 3)
    screen: wp.array[wp.vec3d],
    planes: wp.array[Plane],
    edges: wp.array2d[wp.int32],
    edge_faces: wp.array2d[wp.int32],
    ends: wp.array[wp.int32],  # (E,) inclusive sums of the counts
    window: Window,
    tile_ends: wp.array[wp.int32],
    tile_members: wp.array[wp.int32],
    # Out:
    segment_edges: wp.array[wp.int32],  # (P,) edge
    segment_fractions: wp.array[wp.float64],  # (P,) place on the edge, 0 to 1
    segment_points: wp.array[wp.vec3d],  # (P,) column, row [px] and z [m] of the outline
    segment_normals: wp.array[wp.vec2d],  # (P,) unit, pointing out of the body
    segment_lengths: wp.array[wp.float64],  # (P,) visible length [px]
    segment_open: wp.array[wp.float64],  # (P,) share of it with nothing behind
    segment_behind: wp.array[wp.float64],  # (P,) mean z [m] behind the rest, NaN where all is open
    segment_faces: wp.array2d[wp.int32],  # (P, 2) triangle in front and behind, -1 for none
):
    """Write one record a segment.

    Between the nodes of neighbouring segments the view past the edge may change: where the edge
    passes behind another part of the body, or another outline passes behind it. The place is
    found by bisection, so that such segments count for their visible part.
    """
    edge = wp.tid()
    first = wp.int32(0)
    if edge > 0:
        first = ends[edge - 1]
    count = ends[edge] - first
    if count == 0:
        return
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    half = wp.float64(0.5)
    a = screen[edges[edge, 0]]
    b = screen[edges[edge, 1]]
    seen = edge_faces[edge, seen_side(planes, edge_faces, edge)]
    rate = wp.vec2d(b[0] - a[0], b[1] - a[1])
    length = wp.length(rate)
    normal = outward_normal(triangles, screen, seen, a, b)
    column = cell_of(a[0])
    row = cell_of(a[1])
    fraction = zero
    last_node = zero
    # Not at the very ends, where the neighbouring edges take over.
    last_visibility = visibility_at(
        a, b, wp.float64(0.01), normal, planes, window, tile_ends, tile_members
    )
    sums = Sums()
    for index in range(count + 1):
        leave = one
        node = wp.float64(0.99)
        to_column = one
        to_row = one
        if index < count:
            to_column = next_crossing(a[0], rate[0], column)
            to_row = next_crossing(a[1], rate[1], row)
            leave = wp.clamp(wp.min(to_column, to_row), fraction, one)
            if index == count - 1:
                leave = one
            node = half * (fraction + leave)
        visibility = visibility_at(a, b, node, normal, planes, window, tile_ends, tile_members)
        if index == count:
            node = one
        depth = one / (a[2] + node * (b[2] - a[2]))
        change = node
        if not are_alike(last_visibility, visibility, depth):
            change = place_of_change(
                a,
                b,
                last_node,
                node,
                last_visibility,
                normal,
                planes,
                window,
                tile_ends,
                tile_members,
            )
        # The stretch from the last node belongs to the last segment up to `fraction`.
        border = fraction
        if index == count:
            border = one
        sums = added(sums, length * (wp.min(change, border) - last_node), last_visibility)
        sums = added(sums, length * (border - wp.max(change, last_node)), visibility)
        if index > 0:
            write_sums(first + index - 1, sums, segment_lengths, segment_open, segment_behind)
        if index < count:
            sums = Sums()
            sums = added(sums, length * (change - border), last_visibility)
            sums = added(sums, length * (node - wp.max(change, border)), visibility)
            record = first + index
            segment_edges[record] = edge
            segment_fractions[record] = node
            segment_points[record] = wp.vec3d(a[0] + node * rate[0], a[1] + node * rate[1], depth)
            segment_normals[record] = normal
            segment_faces[record, 0] = seen
            segment_faces[record, 1] = visibility.face
            last_node = node
            last_visibility = visibility
            fraction = leave
            if to_column < to_row:
                column += wp.where(rate[0] > zero, 1, -1)
            else:
                row += wp.where(rate[1] > zero, 1, -1)
