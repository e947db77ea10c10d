# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the model shows against what was measured, and what was measured against the model."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.measured_body import MeasuredShares
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.residuals.robust_loss import cost_of_missing, robust_cost
from diffcal_ros.calibration.residuals.robust_residual import Comparison


@dataclass(frozen=True)
class TwoWayComparison:
    """All views compared, and what of the measured body lies beside them.

    Attributes:
        compared: of each view, without the sensor's bias of edges.
        shares: of the measured body, of each view.
    """

    compared: Sequence[Comparison]
    shares: Sequence[MeasuredShares]

    def gap(self, truncation: float) -> Gap:
        """Measure the gap, where residuals beyond a truncation [m] are not of the body."""
        differences = [c.difference for c in self.compared]
        return measure_gap(
            differences, [c.counted for c in self.compared], truncation, self.shares
        )

    def misfit(self, scales: Scales) -> float:
        """Return half chi-square, in which what was measured and not simulated counts, too.

        A measured pixel that nothing covers costs as much as a rendered one that was not measured.

        Args:
            scales: under which the views were compared.
        """
        beside = sum(share.unexplained for share in self.shares)
        cost = sum(robust_cost(own, scales) for c in self.compared for own in c.both)
        return float(cost + cost_of_missing(beside, scales))
