# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""The term that stiffens a rubber at large strain (Yeoh 1993, second coefficient).

    psi = mu/2 (I_C - 3)^2        with I_C = tr(F^T F)

to be added to a neo-Hookean energy. `mu` stands for C2/C1 times the shear modulus, C1 being half
of that. At rest neither stress nor stiffness change.
"""

import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.struct
class Point:
    """What the stiffness blocks of one quadrature point share."""

    F: wp.mat33d
    geometric: wp.float64
    stretch: wp.float64


@wp.func
def energy_density(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return psi [J/m^3]."""
    stretch = wp.ddot(F, F) - wp.float64(3.0)
    return wp.float64(0.5) * mu * stretch * stretch


@wp.func
def stress(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the first Piola-Kirchhoff stress [Pa]."""
    return wp.float64(2.0) * mu * (wp.ddot(F, F) - wp.float64(3.0)) * F


@wp.func
def stress_tangent(F: wp.mat33d, dF: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the derivative of the stress along dF."""
    stretch = wp.ddot(F, F) - wp.float64(3.0)
    return wp.float64(2.0) * mu * stretch * dF + wp.float64(4.0) * mu * wp.ddot(F, dF) * F


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
    result.F = F
    result.geometric = wp.float64(2.0) * mu * (wp.ddot(F, F) - wp.float64(3.0))
    if is_guarded:
        result.geometric = wp.max(result.geometric, wp.float64(0.0))
    result.stretch = wp.float64(4.0) * mu
    return result


@wp.func
def stiffness_block(here: Point, gradient_a: wp.vec3d, gradient_b: wp.vec3d):
    """Return d2 psi / dx_a dx_b for two nodes with these shape gradients."""
    diagonal = here.geometric * wp.dot(gradient_a, gradient_b)
    block = here.stretch * wp.outer(here.F * gradient_a, here.F * gradient_b)
    return block + diagonal * wp.identity(n=3, dtype=wp.float64)
