# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the model shows against what was measured, and what was measured against the model."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.measured_body import MeasuredShares
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.residuals.robust_loss import (
    cost_of_missing,
    robust_cost,
    worst_cost,
)
from diffcal_ros.calibration.residuals.robust_residual import Comparison


class Misfit(NamedTuple):
    """How well a place explains the images, in units of half chi-square, priors included.

    Attributes:
        above_absence: misfit above that of images without the body, negative where the body is
            found: by it places are compared.
        left: what the body's own residuals cost and what of it has no counterpart: a
            fraction of it tells nothing, because what a model leaves is not noise alone.
    """

    above_absence: float
    left: float

    def is_worse(self, best: 'Misfit', fraction: float, least: float = 0.0) -> bool:
        """Tell whether a place is worse than another by more than what tells nothing.

        Args:
            best: the other one's.
            fraction: of what the other one leaves.
            least: half chi-square that always tells nothing.
        """
        return self.above_absence - best.above_absence > max(least, fraction * best.left)


@dataclass(frozen=True)
class TwoWayComparison:
    """All views compared, and what of the measured body lies beside them.

    Attributes:
        compared: of each view, without the sensor's bias of edges.
        fractions: of the measured body, of each view.
    """

    compared: Sequence[Comparison]
    fractions: Sequence[MeasuredShares]

    def gap(self, truncation: float) -> Gap:
        """Measure the gap, where residuals beyond a truncation [m] are not of the body."""
        differences = [c.difference for c in self.compared]
        return measure_gap(
            differences, [c.counted for c in self.compared], truncation, self.fractions
        )

    def misfit(self, scales: Scales) -> float:
        """Return half chi-square, in which what was measured and not simulated counts, too.

        A measured pixel that nothing covers costs as much as a rendered one that was not measured.

        Args:
            scales: under which the views were compared.
        """
        beside = sum(fraction.unexplained for fraction in self.fractions)
        cost = sum(robust_cost(own, scales) for c in self.compared for own in c.both)
        return float(cost + cost_of_missing(beside, scales))

    def gain(self, scales: Scales) -> float:
        """Return how much better the body explains the images than its absence [half chi-square].

        Each pixel of an image shows the body, and then costs what its residual does, or something
        else, and then costs as much as the worst residual. So a place gains by every pixel and
        piece of outline that it meets, and loses by pixels that see through it and outline that
        is not there; what hides it, or stands beside it, says nothing. Costs alone are no measure
        of places: they grow with what is compared, and a body that turns its edge to the camera
        has few pixels to be off by. (Torr and Zisserman 2000, MLESAC, score hypotheses by the
        same mixture of what is explained and what is not.)

        Args:
            scales: under which the views were compared.
        """
        found = sum(
            worst_cost(float(own.weights.sum()), own.kind, scales) - robust_cost(own, scales)
            for c in self.compared
            for own in c.both
        )
        hidden = sum(
            min(c.depth.missing, fraction.hidden)
            for c, fraction in zip(self.compared, self.fractions, strict=True)
        )
        return float(found + cost_of_missing(hidden, scales))
