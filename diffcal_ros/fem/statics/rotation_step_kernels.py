# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernel of a step that turns elements instead of stretching them."""

from diffcal_ros.fem.elements.element_kernels import gradient_at, scatter_stress
import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.func
def exponential_of_spin(spin: wp.vec3d):
    """Return the rotation of a rotation vector [rad] (Rodrigues)."""
    one = wp.float64(1.0)
    zero = wp.float64(0.0)
    square = wp.dot(spin, spin)
    cross = wp.mat33d(zero, -spin[2], spin[1], spin[2], zero, -spin[0], -spin[1], spin[0], zero)
    first = one - square / wp.float64(6.0)
    second = wp.float64(0.5) - square / wp.float64(24.0)
    if square > wp.float64(1.0e-8):
        angle = wp.sqrt(square)
        first = wp.sin(angle) / angle
        second = (one - wp.cos(angle)) / square
    return wp.identity(3, dtype=wp.float64) + first * cross + second * (cross * cross)


@wp.kernel(enable_backward=False)
def add_turned_gradients(
    # In:
    nodes: wp.array2d[wp.int32],  # (T, n)
    gradients: wp.array3d[wp.vec3d],  # (T, q, n) [1/m]
    weights: wp.array2d[wp.float64],  # (T, q) [m^3]
    positions: wp.array[wp.vec3d],  # (N,) [m]
    direction: wp.array[wp.vec3d],  # (N,) [m]
    length: wp.float64,
    # Out:
    right_side: wp.array[wp.vec3d],  # (N,) [m^2], accumulated
):
    """Add the wanted deformation gradients, weighted, to the nodes."""
    tet = wp.tid()
    half = wp.float64(0.5)
    for point in range(weights.shape[1]):
        F = gradient_at(positions, nodes, gradients, tet, point)
        rate = length * gradient_at(direction, nodes, gradients, tet, point) * wp.inverse(F)
        spin = half * wp.vec3d(
            rate[2, 1] - rate[1, 2], rate[0, 2] - rate[2, 0], rate[1, 0] - rate[0, 1]
        )
        strain = half * (rate + wp.transpose(rate))
        wanted = exponential_of_spin(spin) * (F + strain * F)
        wanted = weights[tet, point] * wanted
        scatter_stress(wanted, nodes, gradients, tet, point, right_side)
