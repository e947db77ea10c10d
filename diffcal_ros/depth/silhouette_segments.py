# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""What a walk along the outline finds, on a device."""

from diffcal_ros.warp_runtime.device_array import zero_floats, zero_ints, zero_points
import warp as wp


@wp.struct
class Segments:
    """Pieces of silhouette edges, cut at the borders of pixels; hidden ones are kept.

    Attributes:
        count: of pieces.
        edges: surface edge, shape (P,).
        fractions: place on the edge, 0 to 1, shape (P,).
        points: column, row [px] and z [m] of the outline there, shape (P,).
        normals: unit, pointing out of the body, shape (P,).
        lengths: visible length [px], shape (P,).
        open: share of it with nothing behind, shape (P,).
        behind: mean z [m] behind the rest, NaN where all is open, shape (P,).
        faces: triangle in front and behind, -1 for none, shape (P, 2).
    """

    count: wp.int32
    edges: wp.array[wp.int32]
    fractions: wp.array[wp.float64]
    points: wp.array[wp.vec3d]
    normals: wp.array[wp.vec2d]
    lengths: wp.array[wp.float64]
    open: wp.array[wp.float64]
    behind: wp.array[wp.float64]
    faces: wp.array2d[wp.int32]


def make_segments(count: int, device: str) -> Segments:
    """Make room for a walk of so many pieces."""
    segments = Segments()
    segments.count = count
    segments.edges = zero_ints(count, device)
    segments.points = zero_points(count, device)
    segments.normals = wp.zeros(count, dtype=wp.vec2d, device=device)
    segments.faces = zero_ints((count, 2), device)
    for name in ('fractions', 'lengths', 'open', 'behind'):
        setattr(segments, name, zero_floats(count, device))
    return segments
