# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Creep under a held load: one Prony pair, as a modulus that falls with the time of the load.

Where all stresses relax alike, by the share g with the time tau, the relaxation modulus is
E (1 - g + g exp(-t / tau)). A load that is put on at once and then held strains the body by the
creep compliance, of which that is the Laplace dual (Tschoegl 1989, the standard linear solid):

    E / E(t) = 1 + g / (1 - g) (1 - exp(-(1 - g) t / tau)).

Exact for a linear body under a constant load; inertia and large changes of shape while it creeps
are left out.
"""

from dataclasses import dataclass
from typing import ClassVar

from diffcal_ros.fem.statics.force_changes import Change
import numpy as np

# Shorter relaxation times are over before anything is seen [s].
_SHORTEST = 1e-3


@dataclass(frozen=True)
class Creep:
    """One Prony pair.

    Attributes:
        share: g, of all stresses, that relaxes; 0 for none.
        time: tau [s].
    """

    share: float
    time: float

    def factor(self, held: float) -> float:
        """Return E(t) / E after a load was held for so long [s]; 1 before it was put on."""
        if held <= 0.0 or self.share == 0.0:
            return 1.0
        return 1.0 / (1.0 + self._strained(held))

    def slopes(self, held: float) -> tuple[float, float]:
        """Return the derivatives of the factor by share and by time [1/s]."""
        if held <= 0.0:
            return 0.0, 0.0
        left, tau = 1.0 - self.share, max(self.time, _SHORTEST)
        fall = float(np.exp(-left * held / tau))
        by_share = (1.0 - fall) / left**2 - self.share / left * fall * held / tau
        by_time = -self.share * fall * held / tau**2
        factor = self.factor(held)
        return -(factor**2) * by_share, -(factor**2) * by_time

    def rate(self, held: float) -> float:
        """Return the derivative of the factor by how long a load is held [1/s]."""
        if held <= 0.0 or self.share == 0.0:
            return 0.0
        tau = max(self.time, _SHORTEST)
        fall = float(np.exp(-(1.0 - self.share) * held / tau))
        return -(self.factor(held) ** 2) * self.share / tau * fall

    def _strained(self, held: float) -> float:
        left, tau = 1.0 - self.share, max(self.time, _SHORTEST)
        return self.share / left * float(1.0 - np.exp(-left * held / tau))


NO_CREEP = Creep(0.0, 1.0)


@dataclass(frozen=True)
class CreepChange(Change):
    """A direction in the space of Prony pairs.

    Attributes:
        creep: the pair that the change starts from.
        share: change of g per unit of the parameter.
        time: change of tau [s].
    """

    beyond_gradient: ClassVar[str] = 'creep'
    creep: Creep = NO_CREEP
    share: float = 0.0
    time: float = 0.0

    def along(self, held: float) -> float:
        """Return how the factor changes after a load was held for so long [s]."""
        by_share, by_time = self.creep.slopes(held)
        return self.share * by_share + self.time * by_time
