# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much likelier residuals are with further errors in them, parameters integrated out.

All is linear around a fit, and Gaussian. With `r` the residuals where the parameters are what is
known of them and `W` the inverse of their covariance, of the noise and of what the parameters may
do, an error with the covariance `s^2 U U'` makes them likelier by

    1/2 s^2 c' (I + s^2 A)^-1 c - 1/2 log det(I + s^2 A),    A = U' W U,    c = U' W r.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import precision_of
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class LinearEvidence:
    """Residuals with what else may be in them.

    Attributes:
        weights: inverse covariance [1/m^2], shape (n, n).
        pulls: that times the residuals [1/m], shape (n,).
    """

    weights: FloatArray
    pulls: FloatArray

    @classmethod
    def of_fit(cls, fit: Refit, groups: Sequence[PatchGroup]) -> 'LinearEvidence':
        """Return the evidence of a fit whose parameters may be anything that their priors allow.

        Args:
            fit: with its parameters.
            groups: some of its patches.
        """
        count = len(fit.coordinates)
        values = np.concatenate([group.patches.values for group in groups])
        tangents = np.concatenate([group.patches.jacobian[:, :count] for group in groups])
        mean, precision = regularised_prior(fit.parameters)
        # Residuals fall by their tangents: seen from what is known they are larger by that.
        expected = values + tangents @ (fit.coordinates - (mean - fit.shifts))
        weights = _with_more(precision_of(groups), tangents, precision)
        return cls(weights, weights @ expected)

    def offsets(self) -> FloatArray:
        """Return how far each residual is from what the rest lets expect, in its errors, (n,)."""
        own = np.diag(self.weights)
        return np.asarray(np.abs(self.pulls) / np.sqrt(np.where(own > 0.0, own, np.inf)))

    def gain(self, ways: FloatArray, sizes: FloatArray, places: IntArray | None = None) -> float:
        """Return how much likelier the residuals are with a further error, as a logarithm.

        Args:
            ways: columns of independent errors of size one, shape (p, k).
            sizes: of them, each as likely as the others.
            places: residuals that the rows are of, shape (p,). Default: all.
        """
        own = np.arange(len(self.pulls)) if places is None else places
        values, turns = np.linalg.eigh(ways.T @ self.weights[np.ix_(own, own)] @ ways)
        squares = (turns.T @ (ways.T @ self.pulls[own])) ** 2
        scaled = 1.0 + sizes[:, None] ** 2 * np.maximum(values, 0.0)
        levels = 0.5 * (sizes[:, None] ** 2 * squares / scaled - np.log(scaled)).sum(axis=1)
        return float(np.logaddexp.reduce(levels) - np.log(len(sizes)))


def _with_more(weights: FloatArray, ways: FloatArray, precision: FloatArray) -> FloatArray:
    """Return the inverse covariance with a further error (Woodbury), shape (n, n)."""
    pulled = weights @ ways
    information = ways.T @ pulled + precision
    return np.asarray(weights - pulled @ np.linalg.solve(information, pulled.T))
