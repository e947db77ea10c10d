# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernel of the ray tracer that the tests hold the tracer against."""

import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.kernel(enable_backward=False)
def cast_rays(
    # In:
    mesh: wp.uint64,
    directions: wp.array[wp.vec3f],  # (R,) with z = 1
    # Out:
    depth: wp.array[wp.float32],  # (R,) z [m], NaN where nothing is hit
):
    """Cast one ray a pixel from the camera's origin."""
    ray = wp.tid()
    depth[ray] = wp.float32(wp.nan)
    direction = wp.normalize(directions[ray])
    hit = wp.mesh_query_ray(mesh, wp.vec3f(), direction, wp.float32(100.0))
    if hit.result:
        depth[ray] = hit.t * direction[2]
