# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels of strain-rate damping: forces, their derivatives by positions and velocities.

With F the deformation gradient, L = dF/dt and D = sym(F^T L), the stress is beta F D. Along
(dF, dL) it changes by

    beta (dF D + F sym(dF^T L + F^T dL)).

An implicit step ties dL = rate dF. Its main part, rate beta F sym(F^T dF), is symmetric and is
assembled in `step_kernels`; the rest, which is smaller by strain per step, is not symmetric and
is left to `viscous_rest`.
"""

from diffcal_ros.fem.elements.element_kernels import gradient_at, scatter_stress
import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.func
def symmetric(A: wp.mat33d):
    """Return the symmetric part."""
    return wp.float64(0.5) * (A + wp.transpose(A))


@wp.kernel
def viscous_forces(
    # In:
    nodes: wp.array2d[wp.int32],  # (T, n)
    gradients: wp.array3d[wp.vec3d],  # (T, q, n) [1/m]
    weights: wp.array2d[wp.float64],  # (T, q) [m^3]
    beta: wp.array[wp.float64],  # (T,) [Pa s]
    positions: wp.array[wp.vec3d],  # (N,) [m]
    velocities: wp.array[wp.vec3d],  # (N,) [m/s]
    # Out:
    internal: wp.array[wp.vec3d],  # (N,) [N], accumulated
):
    """Add the forces of damping, on the side of elastic forces."""
    tet = wp.tid()
    for point in range(weights.shape[1]):
        F = gradient_at(positions, nodes, gradients, tet, point)
        L = gradient_at(velocities, nodes, gradients, tet, point)
        D = symmetric(wp.transpose(F) * L)
        P = weights[tet, point] * beta[tet] * (F * D)
        scatter_stress(P, nodes, gradients, tet, point, internal)


@wp.kernel
def viscous_tangent(
    # In:
    nodes: wp.array2d[wp.int32],
    gradients: wp.array3d[wp.vec3d],
    weights: wp.array2d[wp.float64],
    beta: wp.array[wp.float64],
    positions: wp.array[wp.vec3d],
    velocities: wp.array[wp.vec3d],
    moved: wp.array[wp.vec3d],  # (N,) change of positions [m]
    sped: wp.array[wp.vec3d],  # (N,) change of velocities [m/s]
    # Out:
    internal: wp.array[wp.vec3d],  # (N,) [N], accumulated
):
    """Add how forces follow changes of positions and velocities."""
    tet = wp.tid()
    for point in range(weights.shape[1]):
        F = gradient_at(positions, nodes, gradients, tet, point)
        L = gradient_at(velocities, nodes, gradients, tet, point)
        dF = gradient_at(moved, nodes, gradients, tet, point)
        dL = gradient_at(sped, nodes, gradients, tet, point)
        D = symmetric(wp.transpose(F) * L)
        dD = symmetric(wp.transpose(dF) * L + wp.transpose(F) * dL)
        P = weights[tet, point] * beta[tet] * (dF * D + F * dD)
        scatter_stress(P, nodes, gradients, tet, point, internal)


@wp.kernel
def viscous_velocity_tangents(
    # In:
    nodes: wp.array2d[wp.int32],
    gradients: wp.array3d[wp.vec3d],
    weights: wp.array2d[wp.float64],
    beta: wp.array[wp.float64],
    positions: wp.array[wp.vec3d],
    velocities: wp.array[wp.vec3d],
    sped: wp.array2d[wp.vec3d],  # (k, N) changes of velocities [m/s]
    # Out:
    internal: wp.array2d[wp.vec3d],  # (k, N) [N], accumulated
):
    """Add how forces follow each change of velocities: beta F sym(F^T dL)."""
    tet = wp.tid()
    for point in range(weights.shape[1]):
        F = gradient_at(positions, nodes, gradients, tet, point)
        weight = weights[tet, point] * beta[tet]
        for side in range(sped.shape[0]):
            dL = gradient_at(sped[side], nodes, gradients, tet, point)
            P = weight * (F * symmetric(wp.transpose(F) * dL))
            scatter_stress(P, nodes, gradients, tet, point, internal[side])


@wp.kernel
def viscous_rest(
    # In:
    nodes: wp.array2d[wp.int32],
    gradients: wp.array3d[wp.vec3d],
    weights: wp.array2d[wp.float64],
    beta: wp.array[wp.float64],
    positions: wp.array[wp.vec3d],
    velocities: wp.array[wp.vec3d],
    directions: wp.array2d[wp.vec3d],  # (k, N)
    is_transposed: wp.bool,
    # Out:
    internal: wp.array2d[wp.vec3d],  # (k, N) accumulated
):
    """Add what the assembled stiffness leaves out, times each direction."""
    tet = wp.tid()
    for point in range(weights.shape[1]):
        F = gradient_at(positions, nodes, gradients, tet, point)
        L = gradient_at(velocities, nodes, gradients, tet, point)
        rate = symmetric(wp.transpose(F) * L)
        weight = weights[tet, point] * beta[tet]
        for side in range(directions.shape[0]):
            dF = gradient_at(directions[side], nodes, gradients, tet, point)
            P = dF * rate
            if is_transposed:
                P += L * symmetric(wp.transpose(F) * dF)
            else:
                P += F * symmetric(wp.transpose(L) * dF)
            scatter_stress(weight * P, nodes, gradients, tet, point, internal[side])
