# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A robust cost that does not jump where residuals come and go.

A stretch of outline whose edge is suddenly not found costs as if it were as far off as was looked:
on a real capture the cost leaps by 13 % over a step of a hundredth of a degree, and no step would
be taken. Here every view's residuals of each kind count by their mean, times how many there were
at first; how many were lost is told beside it.
"""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.robust_loss import robust_cost
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Merit:
    """Costs of each view's depths and edges at some coordinates.

    Attributes:
        costs: of what was found, shape (2 V,).
        weights: of what was found, shape (2 V,).
        missing: weights of what was not, shape (2 V,).
        prior: half chi-square of the ordinary priors.
    """

    costs: FloatArray
    weights: FloatArray
    missing: FloatArray
    prior: float

    def cost(self, first: 'Merit') -> float:
        """Return half chi-square as if as much had been found as at first."""
        means = self.costs / np.maximum(self.weights, 1e-12)
        return float(first.weights @ means) + self.prior

    def lost(self, first: 'Merit') -> float:
        """Return which share more was not found than at first, in the view that lost most."""
        whole = np.maximum(first.weights + first.missing, 1e-12)
        return float(((self.missing - first.missing) / whole).max())


def measure_merit(objective: RobustObjective, coordinates: FloatArray) -> Merit:
    """Measure the merit of the model as it is.

    Args:
        objective: with its scales.
        coordinates: of the ordinary parameters, shape (k,).

    Raises:
        EquilibriumError: when a posture has no equilibrium.
        OutOfViewError: when a camera does not see the body.
    """
    costs, weights, missing = [], [], []
    for comparison in objective.comparisons(coordinates):
        for residuals in objective.unbiased(comparison, coordinates).both:
            costs.append(robust_cost(replace(residuals, missing=0.0), objective.scales))
            weights.append(float(residuals.weights.sum()))
            missing.append(residuals.missing)
    prior = objective.model.parameters.prior().cost(coordinates)
    return Merit(np.array(costs), np.array(weights), np.array(missing), prior)
