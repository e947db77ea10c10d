# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""A law of one's own: neo-Hookean elasticity without a logarithm.

    psi = mu/2 (I_C - 3) - mu (J - 1) + kappa/2 (J - 1)^2

with I_C = tr(F^T F) and J = det F. The second term frees the body at rest of stress. A small
stretch measures Lame's mu = mu and lambda = kappa - mu, which is what CONVERSION says.
"""

from diffcal_ros.fem.laws.stable_neo_hookean import cofactor, cofactor_tangent
from diffcal_ros.material import LameConversion
import warp as wp

wp.set_module_options({'enable_backward': False})

CONVERSION = LameConversion(1.0, 1.0)  # mu is Lame's mu; kappa is lambda and once mu.
TAKES_TURNING_STEPS = True


@wp.struct
class Point:
    """What the stiffness blocks of one quadrature point share."""

    F: wp.mat33d
    cofactor: wp.mat33d
    mu: wp.float64
    kappa: wp.float64
    pressure: wp.float64


@wp.func
def energy_density(F: wp.mat33d, mu: wp.float64, kappa: wp.float64):
    """Return psi [J/m^3]."""
    half = wp.float64(0.5)
    growth = wp.determinant(F) - wp.float64(1.0)
    stretch = wp.ddot(F, F) - wp.float64(3.0)
    return half * mu * stretch - mu * growth + half * kappa * growth * growth


@wp.func
def stress(F: wp.mat33d, mu: wp.float64, kappa: wp.float64):
    """Return the first Piola-Kirchhoff stress [Pa]."""
    pressure = kappa * (wp.determinant(F) - wp.float64(1.0)) - mu
    return mu * F + pressure * cofactor(F)


@wp.func
def stress_tangent(F: wp.mat33d, dF: wp.mat33d, mu: wp.float64, kappa: wp.float64):
    """Return the derivative of the stress along dF."""
    pressure = kappa * (wp.determinant(F) - wp.float64(1.0)) - mu
    cof = cofactor(F)
    return mu * dF + kappa * wp.ddot(cof, dF) * cof + pressure * cofactor_tangent(F, dF)


@wp.func
def stress_of_lame_parameters(
    F: wp.mat33d, mu: wp.float64, kappa: wp.float64, dmu: wp.float64, dkappa: wp.float64
):
    """Return the derivative of the stress along a change of (mu, kappa)."""
    return stress(F, dmu, dkappa)


@wp.func
def point(F: wp.mat33d, mu: wp.float64, kappa: wp.float64, is_guarded: wp.bool):
    """Evaluate what the blocks share; guarded, the pressure stays within what it is at rest."""
    result = Point()
    result.F = F
    result.cofactor = cofactor(F)
    result.mu = mu
    result.kappa = kappa
    result.pressure = kappa * (wp.determinant(F) - wp.float64(1.0)) - mu
    if is_guarded:
        result.pressure = wp.clamp(result.pressure, -mu, mu)
    return result


@wp.func
def stiffness_block(here: Point, gradient_a: wp.vec3d, gradient_b: wp.vec3d):
    """Return d2 psi / dx_a dx_b for two nodes with these shape gradients."""
    Ca = here.cofactor * gradient_a
    Cb = here.cofactor * gradient_b
    turn = here.pressure * (here.F * wp.cross(gradient_a, gradient_b))
    diagonal = here.mu * wp.dot(gradient_a, gradient_b)
    skew = wp.mat33d(
        diagonal, turn[2], -turn[1], -turn[2], diagonal, turn[0], turn[1], -turn[0], diagonal
    )
    return here.kappa * wp.outer(Ca, Cb) + skew
