# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a motion depends on, directions in that space, and derivatives by it."""

from collections.abc import Callable
from dataclasses import dataclass

from diffcal_ros.damping import Damping
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.fem.terms.conditions import Conditions, NO_CONDITIONS
from diffcal_ros.material import Material
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
# Positions of the held vertices [m], shape (h, 3), at a time [s].
HeldMotion = Callable[[float], FloatArray]


class MotionError(NotSimulatedError):
    """No motion was found; the message says what to change."""


@dataclass(frozen=True)
class Release:
    """A support that is taken away.

    Attributes:
        supported_vertices: mesh vertices held besides the clamp until then, shape (s,).
        time: of the release [s], on the axis of the stamps.
        support_positions: where the support holds them [m], world frame, shape (s, 3); None: at
            rest.
    """

    supported_vertices: IntArray
    time: float
    support_positions: FloatArray | None = None


@dataclass(frozen=True)
class MotionInputs:
    """What forces on a moving body depend on.

    Attributes:
        material: one value per tetrahedron.
        damping: one value per tetrahedron.
        gravity: acceleration in the world frame [m/s^2], shape (3,).
        conditions: effects on the body.
    """

    material: Material
    damping: Damping
    gravity: FloatArray
    conditions: Conditions = NO_CONDITIONS


@dataclass(frozen=True)
class MotionChange(Change):
    """A direction in the space of parameters of a motion; parts left out do not change.

    Only a `MotionGradient` knows them.

    Attributes:
        damping: strain-rate damping [Pa s] per unit of the parameter, shape (T,).
        mass_damping: [1/s].
        release_time: [s].
        time_offset: by which stamps are late [s].
    """

    damping: FloatArray | None = None
    mass_damping: float = 0.0
    release_time: float = 0.0
    time_offset: float = 0.0


@dataclass(frozen=True)
class MotionGradient(StaticGradient):
    """Derivative of a scalar by every input of a motion.

    Attributes:
        damping: by each tetrahedron's own strain-rate damping [1/(Pa s)], shape (T,).
        mass_damping: [s].
        release_time: [1/s].
        time_offset: [1/s].
    """

    damping: FloatArray
    mass_damping: float
    release_time: float
    time_offset: float = 0.0

    def along(self, change: Change) -> float:
        """Return the derivative along a change of the inputs.

        Raises:
            NotImplementedError: for a change of effects.
        """
        total = super().along(change)
        if isinstance(change, MotionChange):
            total += self.mass_damping * change.mass_damping
            total += self.release_time * change.release_time
            total += self.time_offset * change.time_offset
            if change.damping is not None:
                total += float(self.damping @ change.damping)
        return total
