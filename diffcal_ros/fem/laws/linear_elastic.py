# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Linear elasticity (Hooke's law), for small strains *and* small turns.

    psi = mu e : e + lambda/2 tr(e)^2        with e = (F + F^T)/2 - I

The strain is the symmetric part of the displacement gradient, which a turn changes: a body that
turns by an angle a is stretched by 1 - cos a in this model, so a beam that hangs down grows. It
is here because the paper compares with it; its modulus is not that of the material when a body
bends far.
"""

from diffcal_ros.material import LameConversion
import warp as wp

wp.set_module_options({'enable_backward': False})

CONVERSION = LameConversion(1.0, 0.0)
TAKES_TURNING_STEPS = False


@wp.struct
class Point:
    """What the stiffness blocks of one quadrature point share."""

    mu: wp.float64
    lam: wp.float64


@wp.func
def stress_of_gradient(H: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return Hooke's stress of a displacement gradient [Pa]."""
    pressure = lam * wp.trace(H)
    return mu * (H + wp.transpose(H)) + pressure * wp.identity(n=3, dtype=wp.float64)


@wp.func
def energy_density(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return psi [J/m^3]."""
    H = F - wp.identity(n=3, dtype=wp.float64)
    return wp.float64(0.5) * wp.ddot(H, stress_of_gradient(H, mu, lam))


@wp.func
def stress(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the stress [Pa]."""
    return stress_of_gradient(F - wp.identity(n=3, dtype=wp.float64), mu, lam)


@wp.func
def stress_tangent(F: wp.mat33d, dF: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """Return the derivative of the stress along dF."""
    return stress_of_gradient(dF, mu, lam)


@wp.func
def stress_of_lame_parameters(
    F: wp.mat33d, mu: wp.float64, lam: wp.float64, dmu: wp.float64, dlam: wp.float64
):
    """Return the derivative of the stress along a change of (mu, lambda)."""
    return stress(F, dmu, dlam)


@wp.func
def point(F: wp.mat33d, mu: wp.float64, lam: wp.float64, is_guarded: wp.bool):
    """Evaluate what the blocks share; the stiffness is the same everywhere, and definite."""
    result = Point()
    result.mu = mu
    result.lam = lam
    return result


@wp.func
def stiffness_block(here: Point, gradient_a: wp.vec3d, gradient_b: wp.vec3d):
    """Return d2 psi / dx_a dx_b for two nodes with these shape gradients."""
    diagonal = here.mu * wp.dot(gradient_a, gradient_b)
    return (
        diagonal * wp.identity(n=3, dtype=wp.float64)
        + here.mu * wp.outer(gradient_b, gradient_a)
        + here.lam * wp.outer(gradient_a, gradient_b)
    )
