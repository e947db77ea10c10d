# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels that tell how far the material around each node has turned."""

from diffcal_ros.fem.elements.element_kernels import gradient_at
import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.kernel
def sum_gradients(
    # In:
    nodes: wp.array2d[wp.int32],  # (T, n)
    gradients: wp.array3d[wp.vec3d],  # (T, q, n) [1/m]
    weights: wp.array2d[wp.float64],  # (T, q) [m^3]
    positions: wp.array[wp.vec3d],  # (N,) [m]
    # Out:
    sums: wp.array[wp.mat33d],  # (N,) deformation gradients times volume [m^3], accumulated
    volumes: wp.array[wp.float64],  # (N,) [m^3], accumulated
):
    """Add the deformation gradient of every tetrahedron to its nodes."""
    tet = wp.tid()
    total = wp.mat33d()
    volume = wp.float64(0.0)
    for point in range(weights.shape[1]):
        weight = weights[tet, point]
        total += weight * gradient_at(positions, nodes, gradients, tet, point)
        volume += weight
    for a in range(nodes.shape[1]):
        wp.atomic_add(sums, nodes[tet, a], total)
        wp.atomic_add(volumes, nodes[tet, a], volume)


@wp.kernel
def find_rotations(
    # In:
    sums: wp.array[wp.mat33d],  # (N,)
    volumes: wp.array[wp.float64],  # (N,)
    # Out:
    rotations: wp.array[wp.mat33d],  # (N,)
):
    """Find the rotation of each mean gradient: its orthogonal polar factor.

    By Newton's iteration R' = (R + R^-T) / 2 (Higham 1986), which takes a stretch of 2 to 1 within
    1e-15 in six rounds. Where a node's surroundings are inside out, it is left unturned.
    """
    node = wp.tid()
    R = sums[node] / wp.max(volumes[node], wp.float64(1.0e-300))
    for _ in range(6):
        size = wp.determinant(R)
        if size > wp.float64(1.0e-3):
            R = wp.float64(0.5) * (R + wp.transpose(wp.inverse(R)))
        else:
            R = wp.identity(n=3, dtype=wp.float64)
    rotations[node] = R
