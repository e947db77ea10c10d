# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pose as a message carries it: in some frame, at some time, known so well."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Correlations nearer to 1 leave nothing to invert.
_FLATTEST = 1e-9


@dataclass(frozen=True)
class StampedPose:
    """A pose that was recorded, or has arrived.

    Attributes:
        frame_from_body: shape (4, 4).
        covariance: as in PoseWithCovariance, of a shift of the body's origin [m] and a turn about
            it [rad] along the frame's axes, shape (6, 6); None where it is not known.
        frame_id: of the header.
        stamp_ns: of the header [ns].
        seen_ids: of a marker or board, the parts that were seen; None where nobody says.
    """

    frame_from_body: FloatArray
    covariance: FloatArray | None
    frame_id: str
    stamp_ns: int = 0
    seen_ids: tuple[int, ...] | None = None


def known_covariance(values: FloatArray) -> FloatArray | None:
    """Read the covariance of a PoseWithCovariance.

    Args:
        values: in the message's order, 36 numbers.

    Returns:
        Shape (6, 6), or None where the message says by zeros (or negative ones) that it is not
        known.

    Raises:
        ValueError: when it is none.
    """
    covariance = np.asarray(values, dtype=np.float64).reshape(6, 6)
    if not np.isfinite(covariance).all():
        raise ValueError('the covariance holds NaN or Inf: publish zeros where it is unknown')
    variances = np.diag(covariance)
    if variances.min() <= 0.0:
        return None
    covariance = 0.5 * (covariance + covariance.T)
    spread = np.sqrt(variances)
    if np.linalg.eigvalsh(covariance / np.outer(spread, spread)).min() < _FLATTEST:
        raise ValueError(
            'the covariance is not positive definite: publish zeros where it is unknown'
        )
    return covariance
