# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""St. Venant-Kirchhoff elasticity: Hooke's law for Green's strain, for large turns.

    psi = mu E : E + lambda/2 tr(E)^2        with E = (F^T F - I)/2

Right for bodies that turn far and strain little. It softens under compression and resists no
collapse (a stretch below 1/sqrt(3)), so its strains should stay under some 20 %.
"""

from diffcal_ros.material import LameConversion
import warp as wp

wp.set_module_options({'enable_backward': False})

CONVERSION = LameConversion(1.0, 0.0)
TAKES_TURNING_STEPS = True


@wp.struct
class Point:
    """What the stiffness blocks of one quadrature point share."""

    F: wp.mat33d
    left: wp.mat33d
    mu: wp.float64
    material_stress: wp.mat33d
    lam: wp.float64


@wp.func
def material_stress(C: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the second Piola-Kirchhoff stress of a strain E = C/2 [Pa]."""
    pressure = wp.float64(0.5) * lam * wp.trace(C)
    return mu * C + pressure * wp.identity(n=3, dtype=wp.float64)


@wp.func
def twice_green_strain(F: wp.mat33d):
    """Return F^T F - I."""
    return wp.transpose(F) * F - wp.identity(n=3, dtype=wp.float64)


@wp.func
def energy_density(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return psi [J/m^3]."""
    strain = twice_green_strain(F)
    return wp.float64(0.25) * wp.ddot(strain, material_stress(strain, mu, lam))


@wp.func
def stress(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the first Piola-Kirchhoff stress [Pa]."""
    return F * material_stress(twice_green_strain(F), mu, lam)


@wp.func
def stress_tangent(F: wp.mat33d, dF: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the derivative of the stress along dF."""
    half = wp.transpose(F) * dF
    change = half + wp.transpose(half)
    here = dF * material_stress(twice_green_strain(F), mu, lam)
    return here + F * material_stress(change, mu, lam)


@wp.func
def stress_of_lame_parameters(
    F: wp.mat33d, mu: wp.float64, lam: wp.float64, dmu: wp.float64, dlam: wp.float64
):
    """Return the derivative of the stress along a change of (mu, lambda)."""
    return stress(F, dmu, dlam)


@wp.func
def point(F: wp.mat33d, mu: wp.float64, lam: wp.float64, is_guarded: wp.bool):
    """Evaluate what the blocks share; guarded, the stress itself adds nothing, so none falls."""
    result = Point()
    result.F = F
    result.left = mu * (F * wp.transpose(F))
    result.mu = mu
    result.lam = lam
    if not is_guarded:
        result.material_stress = material_stress(twice_green_strain(F), mu, lam)
    return result


@wp.func
def stiffness_block(here: Point, gradient_a: wp.vec3d, gradient_b: wp.vec3d):
    """Return d2 psi / dx_a dx_b for two nodes with these shape gradients."""
    Fa = here.F * gradient_a
    Fb = here.F * gradient_b
    tension = wp.dot(gradient_a, here.material_stress * gradient_b)
    return (
        tension * wp.identity(n=3, dtype=wp.float64)
        + wp.dot(gradient_a, gradient_b) * here.left
        + here.mu * wp.outer(Fb, Fa)
        + here.lam * wp.outer(Fa, Fb)
    )
