# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What nuisances can explain within their priors, taken out."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Projection:
    """Takes out what nuisances can explain within their priors."""

    def __init__(self, nuisances: FloatArray, precision: FloatArray) -> None:
        """Prepare the projection.

        Args:
            nuisances: whitened columns, shape (n, k).
            precision: of their priors, shape (k, k).
        """
        information = nuisances.T @ nuisances + precision
        self._pull, self._information = nuisances.T, information
        # Symmetric square root of I - N (N'N + P)^-1 N', so that inner products come out right.
        basis, triangle = np.linalg.qr(nuisances)
        values, turns = np.linalg.eigh(triangle @ np.linalg.inv(information) @ triangle.T)
        vectors = basis @ turns
        shrink = 1.0 - np.sqrt(np.clip(1.0 - values, 0.0, 1.0))
        active = shrink > 1e-12
        self._vectors, self._shrink = vectors[:, active], shrink[active]

    def __call__(self, columns: FloatArray) -> FloatArray:
        """Return whitened columns or residuals, shape (n, ...), without what nuisances explain."""
        inside = self._vectors.T @ columns
        scaled = self._shrink[:, None] * inside if columns.ndim == 2 else self._shrink * inside
        return columns - self._vectors @ scaled

    def followed(self, columns: FloatArray) -> FloatArray:
        """Return by how much a fit of the nuisances follows whitened columns, shape (k, ...)."""
        return np.asarray(np.linalg.solve(self._information, self._pull @ columns))
