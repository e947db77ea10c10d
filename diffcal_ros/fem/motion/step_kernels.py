# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels of an energy law with strain-rate damping: what every step of a motion needs.

Elastic and viscous parts share one pass over the elements, since reading nodes and scattering
take longer than the law. See `viscous_kernels` for the damping.
"""

from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

from diffcal_ros.fem.elements.element_kernels import gradient_at, scatter_block, scatter_stress
from diffcal_ros.fem.motion.viscous_kernels import symmetric
import warp as wp

wp.set_module_options({'enable_backward': False})


@dataclass(frozen=True)
class StepKernels:
    """The kernels of one energy law."""

    forces: Any
    stiffness: Any
    pull_back: Any


@cache
def make_step_kernels(law: ModuleType) -> StepKernels:
    """Build the kernels for a law module."""
    return StepKernels(
        forces=_forces_kernel(law),
        stiffness=_stiffness_kernel(law),
        pull_back=_pull_back_kernel(law),
    )


def _forces_kernel(law: ModuleType) -> Any:
    stress = law.stress

    @wp.kernel(module='unique', enable_backward=False)
    def forces(
        # In:
        nodes: wp.array2d[wp.int32],  # (T, n)
        gradients: wp.array3d[wp.vec3d],  # (T, q, n) [1/m]
        weights: wp.array2d[wp.float64],  # (T, q) [m^3]
        mu: wp.array[wp.float64],  # (T,) [Pa]
        lam: wp.array[wp.float64],  # (T,) [Pa]
        beta: wp.array[wp.float64],  # (T,) [Pa s]
        positions: wp.array[wp.vec3d],  # (N,) [m]
        velocities: wp.array[wp.vec3d],  # (N,) [m/s]
        # Out:
        internal: wp.array[wp.vec3d],  # (N,) [N], accumulated
    ):
        tet = wp.tid()
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            P = stress(F, mu[tet], lam[tet])
            if beta[tet] > wp.float64(0.0):
                L = gradient_at(velocities, nodes, gradients, tet, point)
                P += beta[tet] * (F * symmetric(wp.transpose(F) * L))
            P = weights[tet, point] * P
            scatter_stress(P, nodes, gradients, tet, point, internal)

    return forces


def _stiffness_kernel(law: ModuleType) -> Any:
    evaluate_point = law.point
    stiffness_block = law.stiffness_block

    @wp.kernel(module='unique', enable_backward=False)
    def stiffness(
        # In:
        nodes: wp.array2d[wp.int32],
        gradients: wp.array3d[wp.vec3d],
        weights: wp.array2d[wp.float64],
        mu: wp.array[wp.float64],
        lam: wp.array[wp.float64],
        beta: wp.array[wp.float64],
        positions: wp.array[wp.vec3d],
        rate: wp.float64,  # change of velocity per change of position [1/s]
        slots: wp.array3d[wp.int32],  # (T, pairs, 9) place of each entry in values, or -1
        # Out:
        values: wp.array[wp.float64],  # main part of the step's stiffness [N/m], accumulated
    ):
        tet = wp.tid()
        viscous = wp.float64(0.5) * rate * beta[tet]
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            T = viscous * (F * wp.transpose(F))
            here = evaluate_point(F, mu[tet], lam[tet], False)
            pair = wp.int32(0)
            for a in range(nodes.shape[1]):
                ga = gradients[tet, point, a]
                Fa = viscous * (F * ga)
                for b in range(a, nodes.shape[1]):
                    gb = gradients[tet, point, b]
                    block = stiffness_block(here, ga, gb)
                    if viscous > wp.float64(0.0):
                        block += wp.dot(ga, gb) * T + wp.outer(F * gb, Fa)
                    block = weights[tet, point] * block
                    scatter_block(block, slots, tet, pair, values)
                    pair += 1

    return stiffness


def _pull_back_kernel(law: ModuleType) -> Any:
    stress_tangent = law.stress_tangent
    stress_of_lame_parameters = law.stress_of_lame_parameters

    @wp.kernel(module='unique', enable_backward=False)
    def pull_back(
        # In:
        nodes: wp.array2d[wp.int32],
        gradients: wp.array3d[wp.vec3d],
        weights: wp.array2d[wp.float64],
        mu: wp.array[wp.float64],
        lam: wp.array[wp.float64],
        beta: wp.array[wp.float64],
        positions: wp.array[wp.vec3d],
        velocities: wp.array[wp.vec3d],
        adjoint: wp.array[wp.vec3d],  # (N,)
        has_positions: wp.bool,  # whether anybody asks for by_positions
        # Out:
        by_positions: wp.array[wp.vec3d],  # (N,) adjoint . d forces / d positions, accumulated
        by_velocities: wp.array[wp.vec3d],  # (N,) the same by velocities, accumulated
        by_mu: wp.array[wp.float64],  # (T,) accumulated
        by_lam: wp.array[wp.float64],  # (T,) accumulated
        by_beta: wp.array[wp.float64],  # (T,) accumulated
    ):
        tet = wp.tid()
        one = wp.float64(1.0)
        zero = wp.float64(0.0)
        for point in range(weights.shape[1]):
            weight = weights[tet, point]
            F = gradient_at(positions, nodes, gradients, tet, point)
            L = gradient_at(velocities, nodes, gradients, tet, point)
            A = gradient_at(adjoint, nodes, gradients, tet, point)
            S = symmetric(wp.transpose(F) * A)
            D = symmetric(wp.transpose(F) * L)
            by_mu[tet] += weight * wp.ddot(
                A, stress_of_lame_parameters(F, mu[tet], lam[tet], one, zero)
            )
            by_lam[tet] += weight * wp.ddot(
                A, stress_of_lame_parameters(F, mu[tet], lam[tet], zero, one)
            )
            by_beta[tet] += weight * wp.ddot(S, D)
            if has_positions:
                # The elastic stiffness is symmetric: pulling back is pushing forward.
                P = stress_tangent(F, A, mu[tet], lam[tet]) + beta[tet] * (A * D + L * S)
                P = weight * P
                scatter_stress(P, nodes, gradients, tet, point, by_positions)
            if beta[tet] > wp.float64(0.0):
                Q = weight * beta[tet] * (F * S)
                scatter_stress(Q, nodes, gradients, tet, point, by_velocities)

    return pull_back
