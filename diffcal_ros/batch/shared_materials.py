# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which bodies share a material, told from their values alone."""

from dataclasses import dataclass

from diffcal_ros.batch.random_effects import fit_random_effects, restricted_spread
import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

# Chance to part bodies of one material, and draws that tell it.
_LEVEL, _DRAWS = 0.01, 2000
_FEWEST = 4
# A body is said to be of a material where the chance of that is at least so large.
_SURE = 0.95
_SEED = 19691971


@dataclass(frozen=True)
class SharedMaterials:
    """How many materials explain the values, and whose each is.

    Attributes:
        means: of the materials, ascending, shape (m,).
        spreads: standard deviation between bodies of each, shape (m,).
        chances: of each body to be of each material, shape (n, m).
    """

    means: FloatArray
    spreads: FloatArray
    chances: FloatArray

    @property
    def places(self) -> list[int | None]:
        """Number of each body's material; None where that is unsure."""
        best = np.argmax(self.chances, axis=1)
        return [
            int(place) if self.chances[body, place] >= _SURE else None
            for body, place in enumerate(best)
        ]


def find_shared_materials(values: FloatArray, errors: FloatArray) -> SharedMaterials:
    """Part the bodies where a gap between their values is too wide for one material.

    Gaps between neighbours are weighed by the square root of the bodies on either side, over the
    mean of the middle half of them (the gapping of Wainer and Schacht 1978). How wide the widest
    one of a single material is, with a spread between bodies and each body's own error, is drawn;
    bodies of one material are parted in one of a hundred cases. What was parted is looked at again
    by itself. Materials whose bodies overlap count as one.

    Args:
        values: of the bodies, shape (n,).
        errors: standard errors, shape (n,).
    """
    groups = _groups(np.argsort(values, kind='stable'), values, errors)
    fits = [fit_random_effects(values[own], errors[own]) for own in groups]
    means = np.array([fit.mean for fit in fits])
    spreads = np.nan_to_num(np.array([fit.spread for fit in fits]))
    # A material of few bodies does not know its spread: the widest is as good a guess for it.
    wide = np.where([len(own) < _FEWEST for own in groups], spreads.max(), spreads)
    variances = errors[:, None] ** 2 + wide**2 + np.array([fit.mean_error for fit in fits]) ** 2
    sizes = np.array([len(own) for own in groups])
    logs = np.log(sizes) - 0.5 * (np.log(variances) + (values[:, None] - means) ** 2 / variances)
    return SharedMaterials(means, spreads, np.exp(logs - logsumexp(logs, axis=1)[:, None]))


def _groups(bodies: IntArray, values: FloatArray, errors: FloatArray) -> list[IntArray]:
    """Return groups of bodies, ascending by value; `bodies` are in that order."""
    own, own_errors = values[bodies], errors[bodies]
    if len(bodies) < _FEWEST or np.ptp(own) == 0.0:
        return [bodies]
    random = np.random.default_rng(_SEED)
    deviations = np.hypot(own_errors, restricted_spread(own, own_errors))
    drawn = random.normal(scale=deviations, size=(_DRAWS, len(bodies)))
    limit = np.quantile(_weighted_gaps(np.sort(drawn, axis=1)).max(axis=1), 1.0 - _LEVEL)
    (gaps,) = _weighted_gaps(own[None])
    # Only the widest one: tails of a material in the middle are thin where those of all are not.
    widest = int(np.argmax(gaps))
    if gaps[widest] <= limit:
        return [bodies]
    low, high = np.split(bodies, [widest + 1])
    return [*_groups(low, values, errors), *_groups(high, values, errors)]


def _weighted_gaps(ordered: FloatArray) -> FloatArray:
    """Weigh the gaps of each row of ascending values, shape (k, n - 1)."""
    count = ordered.shape[1]
    below = np.arange(1, count)
    gaps = np.sqrt(below * (count - below) * np.diff(ordered, axis=1))
    outer = (count - 1) // 4
    middle = np.sort(gaps, axis=1)[:, outer : count - 1 - outer]
    return gaps / np.maximum(middle.mean(axis=1, keepdims=True), np.finfo(float).tiny)
