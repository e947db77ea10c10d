# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What may act on a body besides its weight: everything is absent by default."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def _nothing(count: int) -> FloatArray:
    return np.zeros(count)


@dataclass(frozen=True)
class Plane:
    """A rigid frictionless half-space that the body may lie on.

    Attributes:
        normal: unit vector out of it in the world frame, shape (3,).
        height: of its surface along the normal [m].
    """

    normal: FloatArray
    height: float


@dataclass(frozen=True)
class CableState:
    """What a cable in the body is like.

    Attributes:
        rest_length: beyond which it pulls [m].
        stiffness: pull per stretch [N/m].
    """

    rest_length: float
    stiffness: float


@dataclass(frozen=True)
class Conditions:
    """Effects on one body; absent ones leave the model bit for bit as it is.

    Attributes:
        clamp_motion: shift of the clamp [m] and turn about its middle [rad], world frame,
            shape (6,).
        clamp_compliance: turn of the clamp per moment on it [rad/(N m)].
        added_masses: mass added at each node [kg], shape (N,); None for none.
        rest_curvature: curvature of the shape without stress about the two axes across the body
            [1/m], shape (2,).
        strain_stiffening: C2 / C1 of a Yeoh term, C1 being half the shear modulus.
        fibre_ratio: stiffness that fibres add along one direction, over the shear modulus.
        fibre_direction: of the fibres in the body at rest, world frame, shape (3,).
        plane: an obstacle, or None.
        cables: one for each cable of the body, or none: then no cable pulls.
        air_drag: drag coefficient times area of the moving body [m^2]; a body at rest feels none.
    """

    clamp_motion: FloatArray = field(default_factory=lambda: _nothing(6))
    clamp_compliance: float = 0.0
    added_masses: FloatArray | None = None
    rest_curvature: FloatArray = field(default_factory=lambda: _nothing(2))
    strain_stiffening: float = 0.0
    fibre_ratio: float = 0.0
    fibre_direction: FloatArray = field(default_factory=lambda: np.eye(3)[0])
    plane: Plane | None = None
    cables: tuple[CableState, ...] = ()
    air_drag: float = 0.0

    @property
    def moves_clamp(self) -> bool:
        """Tell whether the clamp is elsewhere than it should be."""
        return bool(self.clamp_motion.any()) or self.clamp_compliance != 0.0


NO_CONDITIONS = Conditions()
