# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Stable neo-Hookean elasticity (Smith et al. 2018, equation 13; Arnavaz et al. 2023, eq. 12).

    psi = mu/2 (I_C - 3) - mu/2 log((I_C + 1) / 4) + lambda/2 (J - 1)^2 - 3/4 mu (J - 1)

with I_C = tr(F^T F) and J = det F: the papers' lambda/2 (J - alpha)^2 multiplied out, less a
constant, so that a body at rest has energy 0 and stays well conditioned near nu = 0.5.
The energy, and with it every force, is linear in (mu, lambda).
"""

from diffcal_ros.material import NEO_HOOKEAN_CONVERSION
import warp as wp

wp.set_module_options({'enable_backward': False})

CONVERSION = NEO_HOOKEAN_CONVERSION
TAKES_TURNING_STEPS = True
PRESSES_BY_VOLUME = True


@wp.struct
class Point:
    """What the stiffness blocks of one quadrature point share."""

    F: wp.mat33d
    cofactor: wp.mat33d
    geometric: wp.float64
    stretch: wp.float64
    volumetric: wp.float64
    pressure: wp.float64


@wp.func
def cofactor(F: wp.mat33d):
    """Return dJ/dF."""
    c0 = wp.vec3d(F[0, 0], F[1, 0], F[2, 0])
    c1 = wp.vec3d(F[0, 1], F[1, 1], F[2, 1])
    c2 = wp.vec3d(F[0, 2], F[1, 2], F[2, 2])
    return wp.matrix_from_cols(wp.cross(c1, c2), wp.cross(c2, c0), wp.cross(c0, c1))


@wp.func
def cofactor_tangent(F: wp.mat33d, dF: wp.mat33d):
    """Return the derivative of the cofactor of F along dF."""
    c0 = wp.vec3d(F[0, 0], F[1, 0], F[2, 0])
    c1 = wp.vec3d(F[0, 1], F[1, 1], F[2, 1])
    c2 = wp.vec3d(F[0, 2], F[1, 2], F[2, 2])
    d0 = wp.vec3d(dF[0, 0], dF[1, 0], dF[2, 0])
    d1 = wp.vec3d(dF[0, 1], dF[1, 1], dF[2, 1])
    d2 = wp.vec3d(dF[0, 2], dF[1, 2], dF[2, 2])
    return wp.matrix_from_cols(
        wp.cross(d1, c2) + wp.cross(c1, d2),
        wp.cross(d2, c0) + wp.cross(c2, d0),
        wp.cross(d0, c1) + wp.cross(c0, d1),
    )


@wp.func
def energy_density(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return psi [J/m^3]."""
    one = wp.float64(1.0)
    half = wp.float64(0.5)
    stretch = wp.ddot(F, F) - wp.float64(3.0)
    growth = wp.determinant(F) - one
    return (
        half * mu * (stretch - wp.log(one + wp.float64(0.25) * stretch))
        + half * lam * growth * growth
        - wp.float64(0.75) * mu * growth
    )


@wp.func
def stress(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the first Piola-Kirchhoff stress [Pa]."""
    one = wp.float64(1.0)
    shear = mu * (one - one / (wp.ddot(F, F) + one))
    pressure = lam * (wp.determinant(F) - one) - wp.float64(0.75) * mu
    return shear * F + pressure * cofactor(F)


@wp.func
def stress_tangent(F: wp.mat33d, dF: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the derivative of the stress along dF."""
    one = wp.float64(1.0)
    inverse = one / (wp.ddot(F, F) + one)
    pressure = lam * (wp.determinant(F) - one) - wp.float64(0.75) * mu
    cof = cofactor(F)
    return (
        mu * (one - inverse) * dF
        + wp.float64(2.0) * mu * inverse * inverse * wp.ddot(F, dF) * F
        + lam * wp.ddot(cof, dF) * cof
        + pressure * cofactor_tangent(F, dF)
    )


@wp.func
def stress_of_lame_parameters(
    F: wp.mat33d, mu: wp.float64, lam: wp.float64, dmu: wp.float64, dlam: wp.float64
):
    """Return the derivative of the stress along a change of (mu, lambda)."""
    return stress(F, dmu, dlam)


@wp.func
def point(F: wp.mat33d, mu: wp.float64, lam: wp.float64, is_guarded: wp.bool):
    """Evaluate what the blocks of one quadrature point share.

    Guarded, the pressure in the stiffness stays within what it is at rest: a volume error of a
    Newton step, times a large lambda, is what makes the stiffness indefinite.
    """
    one = wp.float64(1.0)
    limit = wp.float64(0.75) * mu
    inverse = one / (wp.ddot(F, F) + one)
    result = Point()
    result.F = F
    result.cofactor = cofactor(F)
    result.geometric = mu * (one - inverse)
    result.stretch = wp.float64(2.0) * mu * inverse * inverse
    result.volumetric = lam
    result.pressure = lam * (wp.determinant(F) - one) - limit
    if is_guarded:
        result.pressure = wp.clamp(result.pressure, -limit, limit)
    return result


@wp.func
def stiffness_block(here: Point, gradient_a: wp.vec3d, gradient_b: wp.vec3d):
    """Return d2 psi / dx_a dx_b for two nodes with these shape gradients."""
    Fa = here.F * gradient_a
    Fb = here.F * gradient_b
    Ca = here.cofactor * gradient_a
    Cb = here.cofactor * gradient_b
    turn = here.pressure * (here.F * wp.cross(gradient_a, gradient_b))
    diagonal = here.geometric * wp.dot(gradient_a, gradient_b)
    skew = wp.mat33d(
        diagonal, turn[2], -turn[1], -turn[2], diagonal, turn[0], turn[1], -turn[0], diagonal
    )
    return here.stretch * wp.outer(Fa, Fb) + here.volumetric * wp.outer(Ca, Cb) + skew
