# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels that look for the body's observed edge."""

import warp as wp

wp.set_module_options({'enable_backward': False})

_BODY = wp.constant(0)
_BEHIND = wp.constant(1)
_IN_FRONT = wp.constant(2)
_UNKNOWN = wp.constant(3)
# Pixels on each side of an edge that must agree: single flying pixels are no edge.
_RUN = wp.constant(2)


@wp.func
def state_at(
    observed: wp.array2d[wp.float32],
    masked: wp.array2d[wp.uint8],
    column: wp.float64,
    row: wp.float64,
    depth: wp.float64,
    tolerance: wp.float64,
):
    """Classify a pixel: body, behind it (or no return), in front of it, or not to be judged."""
    u = wp.int32(wp.floor(column + wp.float64(0.5)))
    v = wp.int32(wp.floor(row + wp.float64(0.5)))
    if u < 0 or v < 0 or v >= observed.shape[0] or u >= observed.shape[1]:
        return _UNKNOWN
    if masked[v, u] != wp.uint8(0):
        return _UNKNOWN
    seen = wp.float64(observed[v, u])
    if wp.isnan(seen):
        return _BEHIND
    if seen < depth - tolerance:
        return _IN_FRONT
    if seen > depth + tolerance:
        return _BEHIND
    return _BODY


@wp.func
def is_edge(
    observed: wp.array2d[wp.float32],
    masked: wp.array2d[wp.uint8],
    point: wp.vec3d,
    normal: wp.vec2d,
    offset: wp.int32,
    tolerance: wp.float64,
):
    """Tell whether the body ends between offset and offset + 1 pixels along the normal."""
    for step in range(_RUN):
        inner = wp.float64(offset - step)
        outer = wp.float64(offset + 1 + step)
        inside = state_at(
            observed,
            masked,
            point[0] + inner * normal[0],
            point[1] + inner * normal[1],
            point[2],
            tolerance,
        )
        outside = state_at(
            observed,
            masked,
            point[0] + outer * normal[0],
            point[1] + outer * normal[1],
            point[2],
            tolerance,
        )
        if inside != _BODY or outside != _BEHIND:
            return False
    return True


@wp.func
def refined(
    observed: wp.array2d[wp.float32],
    masked: wp.array2d[wp.uint8],
    point: wp.vec3d,
    normal: wp.vec2d,
    offset: wp.int32,
    tolerance: wp.float64,
):
    """Return where between offset and offset + 1 the normal leaves the body's last pixel."""
    half = wp.float64(0.5)
    inner = wp.float64(offset)
    outer = wp.float64(offset + 1)
    for _ in range(6):
        middle = half * (inner + outer)
        state = state_at(
            observed,
            masked,
            point[0] + middle * normal[0],
            point[1] + middle * normal[1],
            point[2],
            tolerance,
        )
        if state == _BODY:
            inner = middle
        else:
            outer = middle
    return half * (inner + outer)


@wp.kernel(enable_backward=False)
def search_edges(
    # In:
    observed: wp.array2d[wp.float32],  # (H, W) [m], NaN invalid
    masked: wp.array2d[wp.uint8],  # (H, W) 1 where nothing may be judged
    points: wp.array[wp.vec3d],  # (P,) column, row [px] and z [m]
    normals: wp.array[wp.vec2d],  # (P,) out of the body
    tolerances: wp.array[wp.float64],  # (P,) [m], 0 skips the segment
    reach: wp.int32,  # [px]
    # Out:
    distances: wp.array[wp.float64],  # (P,) outward distance to the edge [px], NaN for none
):
    """Look outwards and inwards for the nearest observed edge."""
    segment = wp.tid()
    distances[segment] = wp.float64(wp.nan)
    tolerance = tolerances[segment]
    if tolerance <= wp.float64(0.0):
        return
    point = points[segment]
    normal = normals[segment]
    outward_open = wp.bool(True)
    inward_open = wp.bool(True)
    for step in range(reach):
        if outward_open:
            if is_edge(observed, masked, point, normal, step, tolerance):
                distances[segment] = refined(observed, masked, point, normal, step, tolerance)
                return
            state = state_at(
                observed,
                masked,
                point[0] + wp.float64(step) * normal[0],
                point[1] + wp.float64(step) * normal[1],
                point[2],
                tolerance,
            )
            # What stands in front hides the edge; beyond it nothing is known.
            outward_open = state != _IN_FRONT and state != _UNKNOWN
        if inward_open:
            if is_edge(observed, masked, point, normal, -step - 1, tolerance):
                distances[segment] = refined(observed, masked, point, normal, -step - 1, tolerance)
                return
            state = state_at(
                observed,
                masked,
                point[0] - wp.float64(step) * normal[0],
                point[1] - wp.float64(step) * normal[1],
                point[2],
                tolerance,
            )
            inward_open = state != _IN_FRONT and state != _UNKNOWN
