# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies that do not belong to the material of the others."""

import math

from diffcal_ros.batch.random_effects import restricted_spread
import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Chance that a material without any outlier is told to have one.
_LEVEL = 0.01
# Below so many bodies nothing says which of them is off.
_FEWEST = 5
_MOST_SHARE = 0.25


def find_outliers(values: FloatArray, errors: FloatArray) -> BoolArray:
    """Tell which values are not of the random-effects model of the others, shape (n,).

    The many-outlier procedure of Rosner 1983: the most extreme body is taken away again and again,
    up to a quarter of all, and the last removal that is significant decides, so that several
    outliers cannot hide behind one another. Each is measured by its deleted residual in the
    random-effects model, by Student's t (Viechtbauer and Cheung 2010, equation 9), at 1 % for all
    bodies that are left, together.

    Args:
        values: of the bodies, shape (n,).
        errors: standard errors, shape (n,).
    """
    count = len(values)
    outliers = np.zeros(count, dtype=bool)
    if count < _FEWEST:
        return outliers
    left = np.arange(count)
    removed: list[int] = []
    for _ in range(int(_MOST_SHARE * count)):
        place = _most_extreme(values[left], errors[left])
        rest = np.delete(left, place)
        size = abs(_deleted_residual(values, errors, int(left[place]), rest))
        removed.append(int(left[place]))
        if size > t.isf(0.5 * _LEVEL / len(left), len(rest) - 1):
            outliers[removed] = True
        left = rest
    return outliers


def _most_extreme(values: FloatArray, errors: FloatArray) -> int:
    """Return the place of the largest residual about the middle."""
    # About the median: a mean leans towards those that are to be found.
    variance = restricted_spread(values, errors) ** 2
    sizes = np.abs(values - np.median(values)) / np.sqrt(errors**2 + variance)
    return int(np.argmax(sizes))


def _deleted_residual(
    values: FloatArray, errors: FloatArray, body: int, rest: NDArray[np.intp]
) -> float:
    """Return a body's distance from what the others predict, over its standard error."""
    variance = restricted_spread(values[rest], errors[rest]) ** 2
    weights = 1.0 / (errors[rest] ** 2 + variance)
    mean = float(weights @ values[rest]) / float(weights.sum())
    error = math.sqrt(float(errors[body]) ** 2 + variance + 1.0 / float(weights.sum()))
    return float(values[body] - mean) / error
