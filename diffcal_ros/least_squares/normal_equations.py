# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cost to second order around some coordinates, which add up term by term."""

from dataclasses import dataclass, fields, replace
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
_Equations = TypeVar('_Equations', bound='NormalEquations')

# Directions of less stiffness than this share of the largest are not moved along.
_RANK = 1e-10


class Prior(NamedTuple):
    """What is known of coordinates before any data: half the square of what they are off.

    Attributes:
        mean: shape (k,).
        precision: inverse covariance, shape (k, k), zero where nothing is known.
    """

    mean: FloatArray
    precision: FloatArray

    def cost(self, coordinates: FloatArray) -> float:
        """Return half chi-square of some coordinates, shape (k,)."""
        offset = coordinates - self.mean
        return 0.5 * float(offset @ self.precision @ offset)

    def pull(self, coordinates: FloatArray) -> FloatArray:
        """Return minus the gradient of the cost, shape (k,)."""
        return self.precision @ (self.mean - coordinates)


@dataclass(frozen=True)
class NormalEquations:
    """What a Gauss-Newton step needs.

    Attributes:
        cost: half chi-square.
        negative_gradient: minus its gradient, shape (k,).
        curvature: Gauss-Newton matrix, shape (k, k).
    """

    cost: float
    negative_gradient: FloatArray
    curvature: FloatArray

    @classmethod
    def nothing(cls: type[_Equations], size: int) -> _Equations:
        """Return those of a cost of zero in k = `size` coordinates, to which others are added."""
        matrices = len(fields(cls)) - 2
        return cls(0.0, np.zeros(size), *(np.zeros((size, size)) for _ in range(matrices)))

    def __add__(self: _Equations, other: _Equations) -> _Equations:
        """Return those of the sum of two costs."""
        terms = (getattr(self, own.name) + getattr(other, own.name) for own in fields(self))
        return type(self)(*terms)

    def times(self: _Equations, factor: float) -> _Equations:
        """Return those of a multiple of the cost."""
        return type(self)(*(factor * getattr(self, own.name) for own in fields(self)))

    def placed(self: _Equations, indices: IntArray, size: int) -> _Equations:
        """Return them among more coordinates.

        Args:
            indices: of the own coordinates among all, shape (k,).
            size: number of all.
        """
        whole = self.nothing(size)
        whole.negative_gradient[indices] = self.negative_gradient
        for own in fields(self)[2:]:
            getattr(whole, own.name)[np.ix_(indices, indices)] = getattr(self, own.name)
        return replace(whole, cost=self.cost)

    def under(self: _Equations, prior: Prior, coordinates: FloatArray) -> _Equations:
        """Return them with a prior; what the data alone say stays.

        Args:
            prior: of the coordinates.
            coordinates: around which the equations are, shape (k,).
        """
        return replace(
            self,
            cost=self.cost + prior.cost(coordinates),
            negative_gradient=self.negative_gradient + prior.pull(coordinates),
            curvature=self.curvature + prior.precision,
        )

    def gain(self, step: FloatArray) -> float:
        """Return by how much the cost falls over a step, to second order."""
        return float(self.negative_gradient @ step - 0.5 * step @ self.curvature @ step)


@dataclass(frozen=True)
class Linearisation(NormalEquations):
    """Normal equations, and how sure the data are of the minimum.

    Attributes:
        information: of the data alone, true curvature of the robust cost, shape (k, k).
        gradient_covariance: covariance of the data's part of the gradient, shape (k, k).
    """

    information: FloatArray
    gradient_covariance: FloatArray

    def minimum_shift(self, gradient_change: FloatArray, prior: Prior) -> FloatArray:
        """Return how far the minimum moves where the gradient changes, to first order, (k,).

        Args:
            gradient_change: shape (k,).
            prior: of the coordinates.
        """
        stiffness = self.information + prior.precision
        shift, *_ = np.linalg.lstsq(stiffness, -gradient_change, rcond=_RANK)
        return np.asarray(shift, dtype=np.float64)
