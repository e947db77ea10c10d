# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far a frame is from what the frames before it said, in units of what is usual."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Usual surprises have the mean 1. One above this is not taken for noise: of one parameter's
# noise, one frame in 200 is, of several together far fewer.
_LARGEST_USUAL = 8.0
# Frames until it is known how large surprises usually are, and how it goes on from there.
_LEARNING = 15
_LEARNING_FRACTION = 0.02
# A camera that becomes noisier is not a body that changes for ever.
_UNUSUAL_FRACTION = 0.0005
_LEAST_NEW = 1e-3
# Directions that scatter less than this share of the largest are rounding.
_RANK = 1e-10


class Innovation:
    """Measures the pull of frames on the parameters against the mean pull of those before.

    Attributes:
        new_fraction: share of a gradient's covariance that is new in every frame; the rest is
            structure, which stays from frame to frame.
    """

    def __init__(self) -> None:
        self.new_fraction = 1.0
        self._learned = 0
        self._whitening = np.zeros((0, 0))

    def hold(self, gradient_covariance: FloatArray) -> None:
        """Measure by the covariance of one frame's gradient, shape (k, k)."""
        scale = 1.0 / np.sqrt(np.maximum(np.diag(gradient_covariance), 1e-300))
        values, vectors = np.linalg.eigh(gradient_covariance * np.outer(scale, scale))
        known = values > _RANK * values[-1]
        self._whitening = scale[:, None] * vectors[:, known] / np.sqrt(values[known])

    def least_fraction(self, difference: FloatArray) -> float:
        """Return how much a frame must weigh against those before it: 0 for a usual one.

        Args:
            difference: of its pull from their mean, at the same point, shape (k,).
        """
        whitened = self._whitening.T @ difference
        raw = float(whitened @ whitened) / max(1, len(whitened))
        surprise = raw / self.new_fraction
        self._learn(raw, surprise)
        if self._learned <= _LEARNING or surprise <= _LARGEST_USUAL:
            return 0.0
        return 1.0 - _LARGEST_USUAL / surprise

    def _learn(self, raw: float, surprise: float) -> None:
        self._learned += 1
        fraction = 1.0 / self._learned
        if self._learned > _LEARNING:
            is_usual = surprise <= _LARGEST_USUAL
            fraction = max(fraction, _LEARNING_FRACTION) if is_usual else _UNUSUAL_FRACTION
            raw = min(raw, _LARGEST_USUAL * self.new_fraction)
        self.new_fraction += fraction * (max(raw, _LEAST_NEW) - self.new_fraction)
