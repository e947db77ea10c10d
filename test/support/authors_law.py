# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""The stable neo-Hookean law as the authors' simulator has it: with I_C from F's diagonal only.

That force is no energy's slope and depends on how the body is turned. It is here to meet their
numbers, and shows that nothing else differs.
"""

from diffcal_ros.fem.laws.stable_neo_hookean import (
    cofactor,
    energy_density,
    point,
    stiffness_block,
    stress_tangent,
)
from diffcal_ros.material import PLAIN_CONVERSION
import warp as wp

wp.set_module_options({'enable_backward': False})

__all__ = [
    'CONVERSION',
    'TAKES_TURNING_STEPS',
    'cofactor',
    'energy_density',
    'point',
    'stiffness_block',
    'stress',
    'stress_of_lame_parameters',
    'stress_tangent',
]
CONVERSION = PLAIN_CONVERSION
TAKES_TURNING_STEPS = True


@wp.func
def stress(F: wp.mat33d, mu: wp.float64, lam: wp.float64):
    """First Piola-Kirchhoff stress with I_C taken from the diagonal."""
    one = wp.float64(1.0)
    diagonal = F[0, 0] * F[0, 0] + F[1, 1] * F[1, 1] + F[2, 2] * F[2, 2]
    shear = mu * (one - one / (diagonal + one))
    pressure = lam * (wp.determinant(F) - one) - wp.float64(0.75) * mu
    return shear * F + pressure * cofactor(F)


@wp.func
def stress_of_lame_parameters(
    F: wp.mat33d, mu: wp.float64, lam: wp.float64, dmu: wp.float64, dlam: wp.float64
):
    """The law is linear in its numbers."""
    return stress(F, dmu, dlam)
