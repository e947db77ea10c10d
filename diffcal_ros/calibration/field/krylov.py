# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Solve (S + w Q) u = r for every weight w at once, and say what the data see.

S is what the data know of a field, Q its roughness. Lanczos' process in the inner product of Q,
started from Q^-1 r, builds one space that serves all weights; its Ritz pairs are the patterns that
the data see best, which gives the posterior (Saibaba and Kitanidis 2015, section 3).
"""

from collections.abc import Callable
from dataclasses import dataclass

from diffcal_ros.calibration.field.smoothness import Smoothness
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal

FloatArray = NDArray[np.float64]

_MOST_VECTORS = 160
# Residual of the solution under the lowest weight, over that of zero.
_TOLERANCE = 3e-3
_CHECK_EVERY = 4
_ROUNDING = 1e-10


@dataclass(frozen=True)
class KrylovSpace:
    """What Lanczos' process found.

    Attributes:
        vectors: orthonormal in Q, shape (m, n).
        values: how well the data see each Ritz pattern, descending, shape (m,).
        patterns: the Ritz patterns in the vectors, shape (m, m), a column each.
        start: of r in the Ritz patterns, shape (m,).
    """

    vectors: FloatArray
    values: FloatArray
    patterns: FloatArray
    start: FloatArray

    @property
    def strongest(self) -> float:
        """How well the data see the pattern that they see best."""
        return float(self.values[0])

    def solve(self, weight: float) -> FloatArray:
        """Return u under a weight, shape (n,)."""
        solution: FloatArray = self.vectors.T @ (
            self.patterns @ (self.start / (self.values + weight))
        )
        return solution

    def ritz_vectors(self) -> FloatArray:
        """Return the Ritz patterns, orthonormal in Q, shape (m, n)."""
        found: FloatArray = self.patterns.T @ self.vectors
        return found


def krylov_space(
    known: Callable[[FloatArray], FloatArray],
    smoothness: Smoothness,
    right_side: FloatArray,
    lowest_weight: float,
) -> KrylovSpace:
    """Run Lanczos' process.

    Args:
        known: applies S, shape (n,) to shape (n,).
        smoothness: is Q.
        right_side: r, shape (n,).
        lowest_weight: for which u must be good, as a share of the strongest Ritz value.

    Raises:
        ValueError: when r is zero: there is nothing to build a space from.
    """
    process = _Process(smoothness, right_side)
    most = min(_MOST_VECTORS, len(right_side))
    while True:
        process.step(known)
        count = len(process.diagonal)
        is_over = count >= most or process.is_exhausted
        if is_over or count % _CHECK_EVERY == 0:
            values, patterns = process.ritz()
            fractions = patterns[0] / (values + lowest_weight * values[-1])
            left = process.beside[-1] * abs(float(patterns[-1] @ fractions))
            if is_over or left < _TOLERANCE:
                return KrylovSpace(
                    vectors=np.stack(process.vectors[:count]),
                    values=values[::-1].copy(),
                    patterns=patterns[:, ::-1].copy(),
                    start=process.length * patterns[0, ::-1],
                )


class _Process:
    """Lanczos' process between steps, every vector orthogonal to all others."""

    def __init__(self, smoothness: Smoothness, right_side: FloatArray) -> None:
        self._smoothness = smoothness
        first = smoothness.solve(right_side)
        self.length = float(np.sqrt(max(float(right_side @ first), 0.0)))
        if self.length == 0.0:
            raise ValueError('the right-hand side is zero: no space can be built from it')
        self.vectors, self._duals = [first / self.length], [right_side / self.length]
        self.diagonal: list[float] = []
        self.beside: list[float] = []

    @property
    def is_exhausted(self) -> bool:
        """Tell whether the space holds all that r asks for."""
        return self.beside[-1] < _ROUNDING * max(self.diagonal)

    def step(self, known: Callable[[FloatArray], FloatArray]) -> None:
        """Add a vector."""
        image = known(self.vectors[-1])
        self.diagonal.append(float(self.vectors[-1] @ image))
        fresh = self._smoothness.solve(image)
        basis, duals = np.stack(self.vectors), np.stack(self._duals)
        # Twice: once leaves what rounding makes grow.
        for _ in range(2):
            fresh = fresh - basis.T @ (duals @ fresh)
        dual = self._smoothness.apply(fresh)
        self.beside.append(float(np.sqrt(max(float(fresh @ dual), 0.0))))
        if not self.is_exhausted:
            self.vectors.append(fresh / self.beside[-1])
            self._duals.append(dual / self.beside[-1])

    def ritz(self) -> tuple[FloatArray, FloatArray]:
        """Return Ritz values, ascending, and patterns in the vectors, a column each."""
        values, patterns = eigh_tridiagonal(np.array(self.diagonal), np.array(self.beside[:-1]))
        return values, patterns
