# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels of one energy law: energy, forces, stiffness and their derivatives.

One source for CPU and CUDA, float64, derivatives by hand: no tape runs through a Newton solve.
Loops run over array shapes, so that the compiler does not unroll the 10-node element.
"""

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.func
def gradient_at(
    field: wp.array[wp.vec3d],
    nodes: wp.array2d[wp.int32],
    gradients: wp.array3d[wp.vec3d],
    tet: wp.int32,
    point: wp.int32,
):
    """Return the gradient of a nodal field at a quadrature point."""
    result = wp.mat33d()
    for a in range(nodes.shape[1]):
        result += wp.outer(field[nodes[tet, a]], gradients[tet, point, a])
    return result


@wp.func
def scatter_stress(
    stress: wp.mat33d,
    nodes: wp.array2d[wp.int32],
    gradients: wp.array3d[wp.vec3d],
    tet: wp.int32,
    point: wp.int32,
    forces: wp.array[wp.vec3d],
):
    """Add the nodal forces of a stress that has its weight already: `gradient_at` transposed."""
    for a in range(nodes.shape[1]):
        wp.atomic_add(forces, nodes[tet, a], stress * gradients[tet, point, a])


@wp.func
def scatter_block(
    block: wp.mat33d,
    slots: wp.array3d[wp.int32],
    tet: wp.int32,
    pair: wp.int32,
    values: wp.array[wp.float64],
):
    """Add the stiffness between two nodes to its places in a sparse matrix; -1 is none."""
    for i in range(3):
        for j in range(3):
            slot = slots[tet, pair, 3 * i + j]
            if slot >= 0:
                wp.atomic_add(values, slot, block[i, j])


@wp.func
def stiffness_of_pressure(F: wp.mat33d, gradient_a: wp.vec3d, gradient_b: wp.vec3d):
    """Return what a unit of pressure on the cofactor of F adds between two nodes."""
    turn = F * wp.cross(gradient_a, gradient_b)
    zero = wp.float64(0.0)
    return wp.mat33d(zero, turn[2], -turn[1], -turn[2], zero, turn[0], turn[1], -turn[0], zero)


@wp.kernel(module='unique', enable_backward=False)
def growth_unforeseen(
    # In:
    nodes: wp.array2d[wp.int32],
    gradients: wp.array3d[wp.vec3d],
    before: wp.array[wp.vec3d],  # (N,) [m]
    step: wp.array[wp.vec3d],  # (N,) [m]
    positions: wp.array[wp.vec3d],  # (N,) [m] after the step
    # Out:
    growths: wp.array2d[wp.float64],  # (T, q) ratio of volumes foreseen less that which came
):
    """Compare the volumes after a step with its linear model's."""
    tet = wp.tid()
    for point in range(growths.shape[1]):
        F = gradient_at(before, nodes, gradients, tet, point)
        rate = gradient_at(step, nodes, gradients, tet, point) * wp.inverse(F)
        foreseen = wp.determinant(F) * (wp.float64(1.0) + wp.trace(rate))
        came = wp.determinant(gradient_at(positions, nodes, gradients, tet, point))
        growths[tet, point] = foreseen - came


@dataclass(frozen=True)
class ElementKernels:
    """The kernels of one energy law."""

    energy: Any
    forces: Any
    force_tangent: Any
    force_of_lame_parameters: Any
    number_gradient: Any
    stiffness: Any
    diagonal: Any


def make_element_kernels(law: ModuleType) -> ElementKernels:
    """Build the kernels for a law module such as `stable_neo_hookean`."""
    return ElementKernels(
        energy=_energy_kernel(law),
        forces=_forces_kernel(law),
        force_tangent=_force_tangent_kernel(law),
        force_of_lame_parameters=_force_of_lame_parameters_kernel(law),
        number_gradient=_number_gradient_kernel(law),
        stiffness=_stiffness_kernel(law),
        diagonal=_diagonal_kernel(law),
    )


def _energy_kernel(law: ModuleType) -> Any:
    energy_density = law.energy_density

    @wp.kernel(module='unique', enable_backward=False)
    def energy(
        # In:
        nodes: wp.array2d[wp.int32],  # (T, n)
        gradients: wp.array3d[wp.vec3d],  # (T, q, n) [1/m]
        weights: wp.array2d[wp.float64],  # (T, q) [m^3]
        mu: wp.array[wp.float64],  # (T,) [Pa]
        lam: wp.array[wp.float64],  # (T,) [Pa]
        positions: wp.array[wp.vec3d],  # (N,) [m]
        # Out:
        energies: wp.array[wp.float64],  # (T,) [J]
    ):
        tet = wp.tid()
        total = wp.float64(0.0)
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            total += weights[tet, point] * energy_density(F, mu[tet], lam[tet])
        energies[tet] = total

    return energy


def _forces_kernel(law: ModuleType) -> Any:
    stress = law.stress

    @wp.kernel(module='unique', enable_backward=False)
    def forces(
        # In:
        nodes: wp.array2d[wp.int32],
        gradients: wp.array3d[wp.vec3d],
        weights: wp.array2d[wp.float64],
        mu: wp.array[wp.float64],
        lam: wp.array[wp.float64],
        positions: wp.array[wp.vec3d],
        # Out:
        internal: wp.array[wp.vec3d],  # (N,) [N], energy gradient, accumulated
    ):
        tet = wp.tid()
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            P = weights[tet, point] * stress(F, mu[tet], lam[tet])
            scatter_stress(P, nodes, gradients, tet, point, internal)

    return forces


def _force_tangent_kernel(law: ModuleType) -> Any:
    stress_tangent = law.stress_tangent

    @wp.kernel(module='unique', enable_backward=False)
    def force_tangent(
        # In:
        nodes: wp.array2d[wp.int32],
        gradients: wp.array3d[wp.vec3d],
        weights: wp.array2d[wp.float64],
        mu: wp.array[wp.float64],
        lam: wp.array[wp.float64],
        positions: wp.array[wp.vec3d],
        direction: wp.array[wp.vec3d],  # (N,) [m]
        # Out:
        internal: wp.array[wp.vec3d],  # (N,) [N], stiffness times direction, accumulated
    ):
        tet = wp.tid()
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            dF = gradient_at(direction, nodes, gradients, tet, point)
            dP = weights[tet, point] * stress_tangent(F, dF, mu[tet], lam[tet])
            scatter_stress(dP, nodes, gradients, tet, point, internal)

    return force_tangent


def _force_of_lame_parameters_kernel(law: ModuleType) -> Any:
    stress_of_lame_parameters = law.stress_of_lame_parameters

    @wp.kernel(module='unique', enable_backward=False)
    def force_of_lame_parameters(
        # In:
        nodes: wp.array2d[wp.int32],
        gradients: wp.array3d[wp.vec3d],
        weights: wp.array2d[wp.float64],
        mu: wp.array[wp.float64],
        lam: wp.array[wp.float64],
        dmu: wp.array[wp.float64],  # (T,) [Pa]
        dlam: wp.array[wp.float64],  # (T,) [Pa]
        positions: wp.array[wp.vec3d],
        # Out:
        internal: wp.array[wp.vec3d],  # (N,) [N], accumulated
    ):
        tet = wp.tid()
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            P = weights[tet, point] * stress_of_lame_parameters(
                F, mu[tet], lam[tet], dmu[tet], dlam[tet]
            )
            scatter_stress(P, nodes, gradients, tet, point, internal)

    return force_of_lame_parameters


def _number_gradient_kernel(law: ModuleType) -> Any:
    stress_of_lame_parameters = law.stress_of_lame_parameters

    @wp.kernel(module='unique', enable_backward=False)
    def number_gradient(
        # In:
        nodes: wp.array2d[wp.int32],
        gradients: wp.array3d[wp.vec3d],
        weights: wp.array2d[wp.float64],
        mu: wp.array[wp.float64],
        lam: wp.array[wp.float64],
        positions: wp.array[wp.vec3d],
        adjoint: wp.array[wp.vec3d],  # (N,)
        # Out:
        by_mu: wp.array[wp.float64],  # (T,) adjoint . d internal / d mu
        by_lam: wp.array[wp.float64],  # (T,) adjoint . d internal / d lambda
    ):
        tet = wp.tid()
        one = wp.float64(1.0)
        zero = wp.float64(0.0)
        total_mu = wp.float64(0.0)
        total_lam = wp.float64(0.0)
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            A = weights[tet, point] * gradient_at(adjoint, nodes, gradients, tet, point)
            total_mu += wp.ddot(A, stress_of_lame_parameters(F, mu[tet], lam[tet], one, zero))
            total_lam += wp.ddot(A, stress_of_lame_parameters(F, mu[tet], lam[tet], zero, one))
        by_mu[tet] = total_mu
        by_lam[tet] = total_lam

    return number_gradient


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
        positions: wp.array[wp.vec3d],
        slots: wp.array3d[wp.int32],  # (T, pairs, 9) place of each entry in values, or -1
        is_guarded: wp.bool,
        growths: wp.array2d[wp.float64],  # (T, q) the pressure is that of volumes other by these
        has_growths: wp.bool,
        # Out:
        values: wp.array[wp.float64],  # upper triangle of the stiffness [N/m], accumulated
    ):
        tet = wp.tid()
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            here = evaluate_point(F, mu[tet], lam[tet], is_guarded)
            more = weights[tet, point] * lam[tet] * growths[tet, point]
            pair = wp.int32(0)
            for a in range(nodes.shape[1]):
                for b in range(a, nodes.shape[1]):
                    ga = gradients[tet, point, a]
                    gb = gradients[tet, point, b]
                    block = weights[tet, point] * stiffness_block(here, ga, gb)
                    if has_growths:
                        block += more * stiffness_of_pressure(F, ga, gb)
                    scatter_block(block, slots, tet, pair, values)
                    pair += 1

    return stiffness


def _diagonal_kernel(law: ModuleType) -> Any:
    evaluate_point = law.point
    stiffness_block = law.stiffness_block

    @wp.kernel(module='unique', enable_backward=False)
    def diagonal(
        # In:
        nodes: wp.array2d[wp.int32],
        gradients: wp.array3d[wp.vec3d],
        weights: wp.array2d[wp.float64],
        mu: wp.array[wp.float64],
        lam: wp.array[wp.float64],
        positions: wp.array[wp.vec3d],
        # Out:
        blocks: wp.array[wp.mat33d],  # (N,) stiffness of each node with itself, accumulated
    ):
        tet = wp.tid()
        for point in range(weights.shape[1]):
            F = gradient_at(positions, nodes, gradients, tet, point)
            here = evaluate_point(F, mu[tet], lam[tet], True)
            for a in range(nodes.shape[1]):
                gradient = gradients[tet, point, a]
                wp.atomic_add(
                    blocks,
                    nodes[tet, a],
                    weights[tet, point] * stiffness_block(here, gradient, gradient),
                )

    return diagonal
