# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far residuals are correlated: how many independent ones there really are."""

import numpy as np
from numpy.typing import NDArray
from scipy import fft

FloatArray = NDArray[np.float64]

_LONGEST_LAG = 80


def correlation_lengths(image: FloatArray, mask: NDArray[np.bool_]) -> tuple[float, float]:
    """Estimate the correlation of a residual image from its autocorrelation.

    The mean is kept in: a constant residual is as correlated as can be.

    Args:
        image: residuals, shape (h, w); ignored outside the mask.
        mask: where there are residuals, shape (h, w).

    Returns:
        The side of the square of pixels that is worth one independent residual, and the length
        along a line that is [px]; 1 for white noise.
    """
    correlation = _radial_autocorrelation(image, mask)
    lags = np.arange(len(correlation))
    ends = np.flatnonzero(correlation <= 0.0)
    end = int(ends[0]) if len(ends) else len(correlation)
    area = 1.0 + float((2.0 * np.pi * lags[1:end] * correlation[1:end]).sum())
    line = 1.0 + 2.0 * float(correlation[1:end].sum())
    return float(np.sqrt(area)), line


def _radial_autocorrelation(image: FloatArray, mask: NDArray[np.bool_]) -> FloatArray:
    """Return the mean correlation at each distance [px], 1 at 0."""
    height, width = image.shape
    shape = (
        fft.next_fast_len(height + _LONGEST_LAG, real=True),
        fft.next_fast_len(width + _LONGEST_LAG, real=True),
    )
    products = _self_correlation(np.where(mask, image, 0.0), shape)
    pairs = np.round(_self_correlation(mask.astype(np.float64), shape))
    down = np.fft.fftfreq(shape[0], 1.0 / shape[0])[:, None]
    across = np.fft.fftfreq(shape[1], 1.0 / shape[1])[None, :]
    ring = np.floor(np.hypot(down, across) + 0.5).astype(np.int64)
    near = ring <= _LONGEST_LAG
    product = np.bincount(ring[near], products[near], _LONGEST_LAG + 1)
    count = np.bincount(ring[near], pairs[near], _LONGEST_LAG + 1)
    if count[0] == 0.0 or product[0] <= 0.0:
        return np.ones(1)
    return np.where(count > 0.0, product / np.maximum(count, 1.0), 0.0) / (product[0] / count[0])


def _self_correlation(image: FloatArray, shape: tuple[int, int]) -> FloatArray:
    spectrum = fft.rfft2(image, shape)
    return np.asarray(fft.irfft2(np.abs(spectrum) ** 2, shape))
