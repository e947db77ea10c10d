# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Damping of a body: by the rate of its strain, one value per tetrahedron, and by its velocity."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Damping:
    """What takes energy out of a motion.

    Strain-rate damping has the dissipation potential (Arnavaz et al. 2023, section on viscosity:
    a potential of the strain rate, scaled by beta)

        R = integral over the rest volume of beta/2 D : D,   D = dE/dt = sym(F^T dF/dt)

    with Green's strain E, which gives the first Piola-Kirchhoff stress beta F D and takes
    2 R watts out of the motion. A rigid motion of the body is not damped. For a spin-free rate of
    a body at rest the stress is beta dF/dt, what the authors' simulator (dFlex) adds; that one
    also damps rigid rotations, so its beta is not the same number on a swinging body.

    Attributes:
        strain_rate: beta [Pa s], shape (T,).
        mass: force per momentum, -mass * M * velocity [1/s].
    """

    strain_rate: FloatArray
    mass: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.strain_rate).all() and (self.strain_rate >= 0).all()):
            raise ValueError(
                'strain-rate damping must be finite and not negative in every tetrahedron [Pa s]'
            )
        if not (np.isfinite(self.mass) and self.mass >= 0.0):
            raise ValueError(
                f'mass damping is {self.mass:g} 1/s: it must be finite and not negative'
            )
