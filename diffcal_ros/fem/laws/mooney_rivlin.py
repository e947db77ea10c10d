# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Mooney-Rivlin elasticity of a nearly incompressible rubber, with C01 = C10 / 4.

    psi = C10 (I1 - 3) + C01 (I2 - 3) - (2 C10 + 4 C01) (J - 1) + kappa/2 (J - 1)^2

with I1 = tr(F^T F), I2 = |cof F|^2 and J = det F; the third term frees the body at rest of
stress. It is a polynomial, so tetrahedra that a Newton step turned inside out come back; as kappa
grows it becomes the incompressible law of Mooney (1940) and Rivlin (1948). The first constant is
mu = 2 (C10 + C01), the shear modulus at rest; the second is kappa.
"""

from diffcal_ros.fem.laws.stable_neo_hookean import cofactor, cofactor_tangent
from diffcal_ros.material import LameConversion
import warp as wp

wp.set_module_options({'enable_backward': False})

RATIO = 0.25  # C01 / C10, as Arnavaz et al. 2023 fix it.
# kappa such that a small change of volume measures the bulk modulus lambda + 2/3 mu.
CONVERSION = LameConversion(1.0, 2.0 / 3.0 + (1.0 - 2.0 * RATIO) / (3.0 * (1.0 + RATIO)))
TAKES_TURNING_STEPS = True
PRESSES_BY_VOLUME = True

_FIRST = wp.constant(wp.float64(1.0 / (1.0 + RATIO)))  # 2 C10 / mu
_SECOND = wp.constant(wp.float64(RATIO / (1.0 + RATIO)))  # 2 C01 / mu


@wp.struct
class Point:
    """What the stiffness blocks of one quadrature point share."""

    F: wp.mat33d
    cofactor: wp.mat33d
    left: wp.mat33d
    geometric: wp.float64
    second: wp.float64
    kappa: wp.float64
    pressure: wp.float64


@wp.func
def rest_pressure(mu: wp.float64):
    """Return what the volume term has to push back at rest [Pa]."""
    return mu * (_FIRST + wp.float64(2.0) * _SECOND)


@wp.func
def energy_density(F: wp.mat33d, mu: wp.float64, kappa: wp.float64):
    """Return psi [J/m^3]."""
    half = wp.float64(0.5)
    three = wp.float64(3.0)
    cof = cofactor(F)
    growth = wp.determinant(F) - wp.float64(1.0)
    stretches = _FIRST * (wp.ddot(F, F) - three) + _SECOND * (wp.ddot(cof, cof) - three)
    return half * mu * stretches + growth * (half * kappa * growth - rest_pressure(mu))


@wp.func
def stress(F: wp.mat33d, mu: wp.float64, kappa: wp.float64):
    """Return the first Piola-Kirchhoff stress [Pa]."""
    right = wp.transpose(F) * F
    pressure = kappa * (wp.determinant(F) - wp.float64(1.0)) - rest_pressure(mu)
    second = wp.trace(right) * F - F * right
    return mu * (_FIRST * F + _SECOND * second) + pressure * cofactor(F)


@wp.func
def stress_tangent(F: wp.mat33d, dF: wp.mat33d, mu: wp.float64, kappa: wp.float64):
    """Return the derivative of the stress along dF."""
    right = wp.transpose(F) * F
    half = wp.transpose(F) * dF
    pressure = kappa * (wp.determinant(F) - wp.float64(1.0)) - rest_pressure(mu)
    cof = cofactor(F)
    second = (
        wp.float64(2.0) * wp.trace(half) * F
        + wp.trace(right) * dF
        - dF * right
        - F * (half + wp.transpose(half))
    )
    return (
        mu * (_FIRST * dF + _SECOND * second)
        + kappa * wp.ddot(cof, dF) * cof
        + pressure * cofactor_tangent(F, dF)
    )


@wp.func
def stress_of_lame_parameters(
    F: wp.mat33d, mu: wp.float64, kappa: wp.float64, dmu: wp.float64, dkappa: wp.float64
):
    """Return the derivative of the stress along a change of (mu, kappa)."""
    return stress(F, dmu, dkappa)


@wp.func
def point(F: wp.mat33d, mu: wp.float64, kappa: wp.float64, is_guarded: wp.bool):
    """Evaluate what the blocks share; guarded, the pressure stays within what it is at rest."""
    limit = rest_pressure(mu)
    result = Point()
    result.F = F
    result.cofactor = cofactor(F)
    result.left = F * wp.transpose(F)
    result.second = mu * _SECOND
    result.geometric = mu * (_FIRST + _SECOND * wp.ddot(F, F))
    result.kappa = kappa
    result.pressure = kappa * (wp.determinant(F) - wp.float64(1.0)) - limit
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
    between = wp.dot(gradient_a, gradient_b)
    diagonal = here.geometric * between - here.second * wp.dot(Fa, Fb)
    skew = wp.mat33d(
        diagonal, turn[2], -turn[1], -turn[2], diagonal, turn[0], turn[1], -turn[0], diagonal
    )
    second = wp.float64(2.0) * wp.outer(Fa, Fb) - wp.outer(Fb, Fa) - between * here.left
    return here.second * second + here.kappa * wp.outer(Ca, Cb) + skew
