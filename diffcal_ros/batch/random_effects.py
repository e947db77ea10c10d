# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One material over many bodies, each with an offset of its own.

Of body i a value y_i is known with a standard error s_i. The model is that of random effects

    y_i = mean + b_i + e_i,   b_i ~ N(0, spread^2),   e_i ~ N(0, s_i^2),

DerSimonian and Laird 1986, equation 1. The spread between bodies is found by restricted maximum
likelihood, which is free of the bias that plain maximum likelihood has for want of the mean
(Harville 1977; Viechtbauer 2005).
"""

from dataclasses import dataclass
import math

from diffcal_ros.errors import InputError
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import chi2, norm, t

FloatArray = NDArray[np.float64]

_LEVEL = 0.95
# The spread is looked for from this share of the smallest error up to the width of the data.
_SMALLEST_SHARE = 1e-3
_GRID = 60
# Beyond this multiple of the width of the data no profile ends.
_WIDEST = 1e4


@dataclass(frozen=True)
class RandomEffects:
    """What some bodies say of their material; in the unit of the values.

    Attributes:
        count: bodies.
        mean: of the material.
        mean_error: its standard error, the part that bodies share included.
        interval_95: of the mean.
        spread: standard deviation between bodies; NaN with a single one.
        spread_95: its interval, NaN with a single one.
        prediction_95: where another body's own value is expected; NaN with fewer than three.
        homogeneity_p: chance of as much scatter if all bodies were alike; NaN with a single one.
        offsets: of each body from the mean, drawn towards zero as far as it is unsure, shape (n,).
        offset_errors: their standard errors, shape (n,).
    """

    count: int
    mean: float
    mean_error: float
    interval_95: tuple[float, float]
    spread: float
    spread_95: tuple[float, float]
    prediction_95: tuple[float, float]
    homogeneity_p: float
    offsets: FloatArray
    offset_errors: FloatArray


def fit_random_effects(
    values: FloatArray, errors: FloatArray, shared_error: float = 0.0
) -> RandomEffects:
    """Fit mean and spread of one material.

    The interval of the mean is that of Hartung and Knapp 2001 with Student's t, never narrower
    than with the stated errors alone (Knapp and Hartung 2003); that of the spread is the profile
    of Cochran's Q (Viechtbauer 2007); the one of another body is that of Higgins, Thompson and
    Spiegelhalter 2009; offsets are best linear unbiased predictions (Robinson 1991).

    Args:
        values: of the bodies, shape (n,).
        errors: standard errors, independent of one another, shape (n,).
        shared_error: standard error that all bodies have in common, such as that of one mesh; it
            does not shrink with their number.

    Raises:
        InputError: when there is no body, or an error is not positive.
    """
    _check(values, errors)
    count = len(values)
    spread = restricted_spread(values, errors)
    variance = 0.0 if math.isnan(spread) else spread**2
    mean, mean_variance = _weighted_mean(values, errors, variance)
    if count > 1:
        scatter = cochran_q(values, errors, variance) / (count - 1)
        mean_variance *= max(scatter, 1.0)
        quantile = float(t.ppf(0.5 + 0.5 * _LEVEL, count - 1))
    else:
        quantile = _normal_quantile()
    half = math.hypot(quantile * math.sqrt(mean_variance), _normal_quantile() * shared_error)
    share = variance / (variance + errors**2)
    return RandomEffects(
        count=count,
        mean=mean,
        mean_error=math.hypot(math.sqrt(mean_variance), shared_error),
        interval_95=(mean - half, mean + half),
        spread=spread,
        spread_95=spread_interval(values, errors),
        prediction_95=_prediction(mean, mean_variance, variance, shared_error, count),
        homogeneity_p=float(chi2.sf(cochran_q(values, errors, 0.0), count - 1))
        if count > 1
        else math.nan,
        offsets=share * (values - mean),
        offset_errors=np.sqrt(share * errors**2 + (1.0 - share) ** 2 * mean_variance),
    )


def restricted_spread(values: FloatArray, errors: FloatArray) -> float:
    """Return the spread between bodies that restricted likelihood finds; NaN for a single one.

    Args:
        values: shape (n,).
        errors: standard errors, shape (n,).
    """
    if len(values) < 2:
        return math.nan
    width = float(np.ptp(values))
    if width == 0.0:
        return 0.0
    # The likelihood may have two hills: look everywhere before climbing.
    lowest = math.log(_SMALLEST_SHARE * float(errors.min()))
    grid = np.linspace(lowest, max(math.log(2.0 * width), lowest + 1.0), _GRID)
    heights = restricted_likelihood(values, errors, np.exp(grid))
    place = int(np.argmax(heights))
    ends = grid[max(place - 1, 0)], grid[min(place + 1, _GRID - 1)]
    found = minimize_scalar(
        lambda log: -float(restricted_likelihood(values, errors, np.exp(np.array([log])))[0]),
        bounds=ends,
        method='bounded',
        options={'xatol': 1e-9},
    )
    at_zero = float(restricted_likelihood(values, errors, np.zeros(1))[0])
    return 0.0 if at_zero >= -float(found.fun) else float(math.exp(found.x))


def restricted_likelihood(
    values: FloatArray, errors: FloatArray, spreads: FloatArray
) -> FloatArray:
    """Return the restricted log likelihood at some spreads, up to a constant, shape (k,).

    Harville 1977, section 3: of the contrasts of the values, from which the mean is gone.

    Args:
        values: shape (n,).
        errors: standard errors, shape (n,).
        spreads: shape (k,).
    """
    variances = errors**2 + spreads[:, None] ** 2
    weights = 1.0 / variances
    totals = weights.sum(axis=1)
    means = weights @ values / totals
    misfit = (weights * (values - means[:, None]) ** 2).sum(axis=1)
    return -0.5 * (np.log(variances).sum(axis=1) + np.log(totals) + misfit)


def cochran_q(values: FloatArray, errors: FloatArray, variance: float) -> float:
    """Return the weighted sum of squares about the weighted mean (Cochran 1954).

    Chi-square with n - 1 degrees of freedom where the variance between bodies is the true one.
    """
    mean, _ = _weighted_mean(values, errors, variance)
    return float(((values - mean) ** 2 / (errors**2 + variance)).sum())


def spread_interval(values: FloatArray, errors: FloatArray) -> tuple[float, float]:
    """Return the 95 % interval of the spread; NaN for a single body.

    It holds every spread with which Cochran's Q is no surprise (Viechtbauer 2007, section 2.6).
    """
    if len(values) < 2:
        return math.nan, math.nan
    # A small spread makes Q large, so the lower end belongs to the upper quantile.
    quantiles = chi2.ppf([0.5 + 0.5 * _LEVEL, 0.5 - 0.5 * _LEVEL], len(values) - 1)
    low, high = (_spread_of_q(values, errors, float(quantile)) for quantile in quantiles)
    return low, high


def _spread_of_q(values: FloatArray, errors: FloatArray, aim: float) -> float:
    if cochran_q(values, errors, 0.0) <= aim:
        return 0.0
    widest = _WIDEST * (float(np.ptp(values)) + float(errors.max()))
    return float(brentq(lambda spread: cochran_q(values, errors, spread**2) - aim, 0.0, widest))


def _weighted_mean(values: FloatArray, errors: FloatArray, variance: float) -> tuple[float, float]:
    weights = 1.0 / (errors**2 + variance)
    total = float(weights.sum())
    return float(weights @ values) / total, 1.0 / total


def _prediction(
    mean: float, mean_variance: float, variance: float, shared_error: float, count: int
) -> tuple[float, float]:
    if count < 3:
        return math.nan, math.nan
    half = math.hypot(
        float(t.ppf(0.5 + 0.5 * _LEVEL, count - 2)) * math.sqrt(variance + mean_variance),
        _normal_quantile() * shared_error,
    )
    return mean - half, mean + half


def _normal_quantile() -> float:
    return float(norm.ppf(0.5 + 0.5 * _LEVEL))


def _check(values: FloatArray, errors: FloatArray) -> None:
    if len(values) == 0:
        raise InputError('no body was given: a material is fitted to at least one')
    if not (np.isfinite(values).all() and np.isfinite(errors).all() and (errors > 0.0).all()):
        raise InputError(
            'values or errors are not finite, or an error is not positive: leave such bodies out'
        )
