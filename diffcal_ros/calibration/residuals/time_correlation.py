# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How alike the residuals of successive frames are: how many frames there really are.

What a mesh or a sensor gets wrong stays on the body from frame to frame. Residuals are followed
on the surface, not in the image, through which the body moves.
"""

from collections.abc import Sequence

from diffcal_ros.calibration.residuals.robust_residual import ResidualKind, Residuals
from diffcal_ros.depth.trace import Trace
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Lags from the first one that correlates less than this are noise of the estimate.
_FAINT = 0.05


def surface_parts(trace: Trace, residuals: Residuals) -> tuple[IntArray, int]:
    """Return on which part of the surface each residual lies, shape (M,), and how many there are.

    Args:
        trace: the view.
        residuals: of it; parts are triangles for depths, and surface edges for edges.
    """
    if residuals.kind is ResidualKind.DEPTH:
        return trace.faces.ravel()[residuals.indices], trace.buffers.face_count
    outline = trace.outline
    indices = np.searchsorted(outline.segments, residuals.indices)
    return outline.edges[indices], trace.buffers.edge_count


def part_means(values: FloatArray, parts: IntArray, count: int) -> FloatArray:
    """Return the mean of the values on each part, shape (count,), NaN where there is none."""
    sums, numbers = np.bincount(parts, values, count), np.bincount(parts, minlength=count)
    return np.where(numbers > 0, sums / np.maximum(numbers, 1), np.nan)


def repeated_frames(means: Sequence[FloatArray]) -> float:
    """Estimate how many frames are worth one independent frame.

    The mean is kept in: a residual that stays is as correlated as can be.

    Args:
        means: residual of each part of the surface [m], shape (P,), of each frame, in order of
            time; NaN where there is none.

    Returns:
        1 for independent frames, at most their number.
    """
    frames = np.stack(means)
    count = len(frames)
    power = _mean_product(frames, 0)
    total = 1.0
    for lag in range(1, count):
        fraction = _mean_product(frames, lag) / power if power > 0.0 else 0.0
        if fraction < _FAINT:
            break
        total += 2.0 * (1.0 - lag / count) * fraction
    return float(min(total, count))


def _mean_product(frames: FloatArray, lag: int) -> float:
    products = frames[: len(frames) - lag] * frames[lag:]
    known = np.isfinite(products)
    return float(products[known].mean()) if known.any() else 0.0
