# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cauchy's cost of depths and edges, in units of half a chi-square of independent residuals.

A residual that is worth only 1/n of an independent one, because its neighbours say the same,
weighs 1/n.
"""

from diffcal_ros.calibration.residuals.residual_scales import Scale, Scales
from diffcal_ros.calibration.residuals.robust_residual import ResidualKind, Residuals
from diffcal_ros.least_squares.residual_channel import ResidualChannel, Weights
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of a residual's weight, this share at least stays in the curvature.
_LEAST_CURVATURE = 0.5


def robust_cost(residuals: Residuals, scales: Scales) -> float:
    """Return Cauchy's cost; what was not found counts as far as was looked.

    Args:
        residuals: of one kind, with their shares.
        scales: width, noise and correlation of that kind, and how far was looked.
    """
    scale = scales.of(residuals.kind)
    square = scale.width**2
    costs = 0.5 * square * np.log1p(residuals.values**2 / square)
    total = float(residuals.weights @ costs)
    total += residuals.missing * _worst(scale, scales.reach.of(residuals.kind))
    return total / (scale.noise**2 * scale.patch(residuals.kind.dimension))


def cost_of_missing(pixels: float, scales: Scales) -> float:
    """Return what as many pixels of depth cost that are as far off as was looked."""
    return worst_cost(pixels, ResidualKind.DEPTH, scales)


def worst_cost(weight: float, kind: ResidualKind, scales: Scales) -> float:
    """Return what residuals of one kind cost that are as far off as was looked.

    Args:
        weight: of them in all.
        kind: of them.
        scales: width, noise and correlation of that kind, and how far was looked.
    """
    scale = scales.of(kind)
    worst = _worst(scale, scales.reach.of(kind))
    return float(weight * worst / (scale.noise**2 * scale.patch(kind.dimension)))


def robust_weights(residuals: Residuals, scale: Scale) -> Weights:
    """Weigh residuals by Cauchy's cost.

    Args:
        residuals: of one kind, with their shares.
        scale: width, noise and correlation of that kind.
    """
    ratio = (residuals.values / scale.width) ** 2
    patch = scale.patch(residuals.kind.dimension)
    weight = residuals.weights / (scale.noise**2 * patch) / (1.0 + ratio)
    # The weights alone overstate the curvature, which falls below zero in the tails, and make
    # every step too short; the true one alone makes steps overshoot.
    true = weight * np.maximum((1.0 - ratio) / (1.0 + ratio), 0.0)
    alike = patch / np.maximum(residuals.weights, 1e-12)
    return Weights(weight, np.maximum(true, _LEAST_CURVATURE * weight), true, alike)


def robust_channel(residuals: Residuals, jacobian: FloatArray, scales: Scales) -> ResidualChannel:
    """Weigh residuals whose derivative is known.

    Args:
        residuals: M of one kind.
        jacobian: of the rendered side, shape (M, k).
        scales: of both kinds.
    """
    weights = robust_weights(residuals, scales.of(residuals.kind))
    return ResidualChannel(residuals.values, jacobian, weights, robust_cost(residuals, scales))


def _worst(scale: Scale, limit: float) -> float:
    """Return the cost of a residual as far off as was looked, before it is weighed [m^2]."""
    square = scale.width**2
    return float(0.5 * square * np.log1p(limit**2 / square))
