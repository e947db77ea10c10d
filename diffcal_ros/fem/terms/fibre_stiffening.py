# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""The term that makes a material stiffer along one direction: fibres in a matrix.

    psi = mu/2 E_f^2        with E_f = (|F d|^2 - 1) / 2

to be added to an isotropic energy; E_f is the strain of Green and Lagrange along the direction d
at rest. `mu` stands for the stiffness that it adds to a small pull along d. The first axis of the
rest frame is d: whoever uses this law turns the shape gradients into that frame.
"""

import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.struct
class Point:
    """What the stiffness blocks of one quadrature point share."""

    fibre: wp.vec3d
    geometric: wp.float64
    stretch: wp.float64


@wp.func
def along(F: wp.mat33d):
    """Return F d, the first column."""
    return wp.vec3d(F[0, 0], F[1, 0], F[2, 0])


@wp.func
def in_first_column(v: wp.vec3d):
    """Return the matrix that maps d to a vector and all across to zero."""
    zero = wp.vec3d()
    return wp.matrix_from_cols(v, zero, zero)


@wp.func
def strain(fibre: wp.vec3d):
    """Return the strain of Green and Lagrange along the fibre."""
    return wp.float64(0.5) * (wp.dot(fibre, fibre) - wp.float64(1.0))


@wp.func
def energy_density(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return psi [J/m^3]."""
    stretch = strain(along(F))
    return wp.float64(0.5) * mu * stretch * stretch


@wp.func
def stress(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the first Piola-Kirchhoff stress [Pa]."""
    fibre = along(F)
    return in_first_column(mu * strain(fibre) * fibre)


@wp.func
def stress_tangent(F: wp.mat33d, dF: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the derivative of the stress along dF."""
    fibre = along(F)
    change = along(dF)
    return in_first_column(mu * (wp.dot(fibre, change) * fibre + strain(fibre) * change))


@wp.func
def stress_of_lame_parameters(
    F: wp.mat33d, mu: wp.float64, lam: wp.float64, dmu: wp.float64, dlam: wp.float64
):
    """Return the derivative of the stress along a change of (mu, lambda)."""
    return stress(F, dmu, dlam)


@wp.func
def point(F: wp.mat33d, mu: wp.float64, lam: wp.float64, is_guarded: wp.bool):
    """Evaluate what the blocks of one quadrature point share; guarded, nothing negative."""
    result = Point()
    result.fibre = along(F)
    result.geometric = mu * strain(result.fibre)
    if is_guarded:
        result.geometric = wp.max(result.geometric, wp.float64(0.0))
    result.stretch = mu
    return result


@wp.func
def stiffness_block(here: Point, gradient_a: wp.vec3d, gradient_b: wp.vec3d):
    """Return d2 psi / dx_a dx_b for two nodes with these shape gradients."""
    block = here.stretch * wp.outer(here.fibre, here.fibre)
    block += here.geometric * wp.identity(n=3, dtype=wp.float64)
    return gradient_a[0] * gradient_b[0] * block
