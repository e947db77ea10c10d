# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What may act on a body besides its weight: everything is absent by default."""

from dataclasses import dataclass, field

from diffcal_ros.fem.terms.potential_terms import Potential
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def _nothing(count: int) -> FloatArray:
    return np.zeros(count)


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

    As a change of the conditions it says what each part changes by.

    Attributes:
        clamp_motion: shift of the clamp [m] and turn about its middle [rad], world frame,
            shape (6,).
        clamp_compliance: shift [m] and turn [rad] of the clamp per force [N] and moment [N m] on
            it, world frame, shape (6, 6).
        added_masses: mass added at each node [kg], shape (N,); None for none.
        forces: that stay as they are, on each node [N], world frame, shape (N, 3); None for none.
        rest_curvature: curvature of the shape without stress about the two axes across the body
            [1/m], shape (2,).
        rest_bends: what the twist and these curvatures are more [1/m] in each of as many equal
            parts of the free length, shape (s, 3); None for nothing.
        potentials: that are added to the body's energy, one of a kind at most.
        cables: one for each cable of the body, or none: then no cable pulls.
        air_drag: drag coefficient times area of the moving body [m^2]; a body at rest feels none.
    """

    clamp_motion: FloatArray = field(default_factory=lambda: _nothing(6))
    clamp_compliance: FloatArray = field(default_factory=lambda: np.zeros((6, 6)))
    added_masses: FloatArray | None = None
    forces: FloatArray | None = None
    rest_curvature: FloatArray = field(default_factory=lambda: _nothing(2))
    rest_bends: FloatArray | None = None
    potentials: tuple[Potential, ...] = ()
    cables: tuple[CableState, ...] = ()
    air_drag: float = 0.0

    @property
    def rest_rates(self) -> FloatArray:
        """Twist and curvatures of the shape without stress in equal parts [1/m], shape (s, 3)."""
        bends = np.zeros((1, 3)) if self.rest_bends is None else self.rest_bends
        return bends + np.concatenate([[0.0], self.rest_curvature])

    @property
    def clamp_gives_way(self) -> bool:
        """Tell whether the clamp moves under the body's load."""
        return bool(self.clamp_compliance.any())

    @property
    def clamp_ways(self) -> list[int]:
        """Which numbers of the clamp's motion follow its load, or what it follows."""
        per_load = self.clamp_compliance
        return [int(n) for n in np.flatnonzero(per_load.any(axis=0) | per_load.any(axis=1))]

    @property
    def moves_clamp(self) -> bool:
        """Tell whether the clamp is elsewhere than it should be."""
        return bool(self.clamp_motion.any()) or self.clamp_gives_way

    def joined(self, other: 'Conditions') -> 'Conditions':
        """Return what acts when others do, too; the cables are these."""
        return Conditions(
            self.clamp_motion + other.clamp_motion,
            self.clamp_compliance + other.clamp_compliance,
            _sum(self.added_masses, other.added_masses),
            _sum(self.forces, other.forces),
            self.rest_curvature + other.rest_curvature,
            _sum(self.rest_bends, other.rest_bends),
            (*self.potentials, *other.potentials),
            self.cables,
            self.air_drag + other.air_drag,
        )


def _sum(one: FloatArray | None, other: FloatArray | None) -> FloatArray | None:
    return other if one is None else one if other is None else one + other


NO_CONDITIONS = Conditions()
