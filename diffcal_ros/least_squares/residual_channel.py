# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Residuals of one kind with their weights and derivative: what every cost here is a sum of."""

from collections.abc import Iterable
from dataclasses import dataclass

from diffcal_ros.least_squares.normal_equations import Linearisation, NormalEquations
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Weights:
    """How residuals are weighed, shape (M,) each.

    Attributes:
        gradient: times a residual, minus the derivative of the cost by what was modelled.
        curvature: of the cost, for steps; a robust cost's own falls below zero in its tails.
        true_curvature: second derivative of the cost where it is positive, else 0.
        alike: how many residuals say the same as this one, itself included.
    """

    gradient: FloatArray
    curvature: FloatArray
    true_curvature: FloatArray
    alike: FloatArray

    @classmethod
    def of_squares(cls, weights: FloatArray) -> 'Weights':
        """Return those of plain least squares with independent residuals, shape (M,)."""
        return cls(weights, weights, weights, np.ones_like(weights))


@dataclass(frozen=True)
class ResidualChannel:
    """Residuals of one kind.

    Attributes:
        values: measured less modelled, shape (M,).
        jacobian: derivative of what is modelled by the coordinates, shape (M, k).
        weights: of the values.
        cost: of the channel; also of what was not found.
    """

    values: FloatArray
    jacobian: FloatArray
    weights: Weights
    cost: float

    @property
    def pull(self) -> FloatArray:
        """Minus the derivative of the cost by each modelled value, shape (M,)."""
        return self.weights.gradient * self.values

    def equations(self) -> NormalEquations:
        """Return the channel's part of the normal equations."""
        curvature = self._squared(self.weights.curvature)
        return NormalEquations(self.cost, self.jacobian.T @ self.pull, curvature)

    def linearise(self) -> Linearisation:
        """Return the same, and how sure the channel is of it.

        Residuals that say the same as others pull all in the same direction: the covariance of
        their sum is theirs times how many they are.
        """
        equations = self.equations()
        return Linearisation(
            cost=equations.cost,
            negative_gradient=equations.negative_gradient,
            curvature=equations.curvature,
            information=self._squared(self.weights.true_curvature),
            gradient_covariance=self._squared(self.pull**2 * self.weights.alike),
        )

    def _squared(self, weights: FloatArray) -> FloatArray:
        return (self.jacobian * weights[:, None]).T @ self.jacobian


def linearise(channels: Iterable[ResidualChannel], size: int) -> Linearisation:
    """Add channels up; each is let go before the next is asked for.

    Args:
        channels: of all residuals.
        size: number of coordinates.
    """
    return sum((channel.linearise() for channel in channels), Linearisation.nothing(size))


def equations(channels: Iterable[ResidualChannel], size: int) -> NormalEquations:
    """Add up what a step alone needs; see `linearise`."""
    return sum((channel.equations() for channel in channels), NormalEquations.nothing(size))
