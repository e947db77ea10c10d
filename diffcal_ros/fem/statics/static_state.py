# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body at rest as a value."""

from dataclasses import dataclass

from diffcal_ros.fem.held_part import HeldPath
from diffcal_ros.fem.statics.equilibrium import Equilibrium
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.material import Material
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class StaticState:
    """A body at rest, and all that this depends on: a value that a body can come back to.

    Attributes:
        material: one value per tetrahedron.
        gravity: [m/s^2], shape (3,).
        conditions: effects on the body.
        held_path: of the held vertices in the body's own frame; None: they stay.
        clamp_gave_way: by which shift [m] and turn [rad], shape (6,).
        own: the equilibrium in the body's own frame.
        positions: of the nodes in the world frame [m], shape (N, 3).
    """

    material: Material
    gravity: FloatArray
    conditions: Conditions
    held_path: HeldPath | None
    clamp_gave_way: FloatArray
    own: Equilibrium
    positions: FloatArray
