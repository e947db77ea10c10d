# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tell steps that lead somewhere from steps that only follow a gradient's noise.

Pixels and pieces of outline join and leave a comparison as the body moves, so its gradient is
known to a share of its own standard deviation and no better. A Gauss-Newton iteration then ends
in a cloud around the minimum: each point is a draw, each step is as long as the cloud is wide,
and no step is ever small. The mean of the draws is nearer to the minimum than any of them
(Polyak and Juditsky, 1992, "Acceleration of stochastic approximation by averaging").
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# So many draws are averaged.
_DRAWS = 6
# A mean step below this share of a standard error is none: left out, it adds a hundredth to a
# variance.
_NO_MEAN = 0.1
# Steps within this share of a standard error are the cloud's; longer ones are on their way.
_WIDEST = 1.0


class Wandering:
    """The last points of one form of a cost, and the undamped steps that they propose."""

    def __init__(self) -> None:
        """Begin without points."""
        self._points: list[FloatArray] = []
        self._steps: list[FloatArray] = []

    def add(self, point: FloatArray, step: FloatArray) -> None:
        """Take one more point and the Gauss-Newton step from there, shape (k,) each."""
        self._points = [*self._points[1 - _DRAWS :], point]
        self._steps = [*self._steps[1 - _DRAWS :], step]

    def middle(self, curvature: FloatArray) -> FloatArray | None:
        """Return where the points lie about, shape (k,); None while they lead somewhere.

        Args:
            curvature: Gauss-Newton matrix, priors included, shape (k, k).
        """
        if len(self._steps) < _DRAWS:
            return None
        errors = standard_errors(curvature)
        steps = np.stack(self._steps)
        if (np.abs(steps) > _WIDEST * errors).any():
            return None
        mean = steps.mean(axis=0)
        if (np.abs(mean) > _NO_MEAN * errors).any():
            return None
        middle: FloatArray = np.mean(self._points, axis=0) + mean
        return middle


def standard_errors(curvature: FloatArray) -> FloatArray:
    """Return the standard errors that a curvature of half a chi-square means, shape (k,).

    Args:
        curvature: shape (k, k); what nothing depends on gets zero.
    """
    diagonal = np.diag(curvature)
    scale = np.where(diagonal > 0.0, 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)), 0.0)
    inverse = np.linalg.pinv(curvature * np.outer(scale, scale), rcond=1e-12, hermitian=True)
    errors: FloatArray = scale * np.sqrt(np.maximum(np.diag(inverse), 0.0))
    return errors
