# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A plain ray tracer over Warp's mesh queries: slow, independent, for checks only."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.ray_reference_kernels import cast_rays
import numpy as np
from numpy.typing import NDArray
import warp as wp

FloatArray = NDArray[np.float64]


def trace_rays(
    points_camera: FloatArray,
    triangles: NDArray[np.int32],
    camera: PinholeCamera,
    *,
    device: str = 'cpu',
) -> NDArray[np.float32]:
    """Trace one ray a pixel in single precision.

    Args:
        points_camera: vertices in the camera frame [m], shape (N, 3).
        triangles: shape (F, 3); both sides are hit.
        camera: without distortion.
        device: Warp device.

    Returns:
        z [m], shape (H, W), NaN where nothing is hit.
    """
    mesh = wp.Mesh(
        points=wp.array(points_camera.astype(np.float32), dtype=wp.vec3f, device=device),
        indices=wp.array(triangles.ravel(), dtype=wp.int32, device=device),
    )
    rays = camera.rays().astype(np.float32).reshape(-1, 3)
    depth = wp.zeros(len(rays), dtype=wp.float32, device=device)
    wp.launch(
        cast_rays,
        dim=len(rays),
        inputs=[mesh.id, wp.array(rays, dtype=wp.vec3f, device=device)],
        outputs=[depth],
        device=device,
    )
    result: NDArray[np.float32] = depth.numpy()
    return result.reshape(camera.height, camera.width).copy()
