# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How large the other forms of an effect are, as the data favour it.

A form has many amplitudes, and which of its ways a cause of the world takes nobody knows
beforehand: an error of depth may run along a body, and not across it. Believed to be of its usual
size each way costs its volume, taken or not, so that what can be most ways would be the least
likely. So each way has a size of its own (automatic relevance determination: MacKay, *Bayesian
non-linear modelling for the prediction competition*, ASHRAE Transactions 100, 1994), the likeliest
with all parameters integrated out around a fit, under a half Cauchy prior.
"""

from collections.abc import Mapping
from dataclasses import replace
import re

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.any_form import log_prior
from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.patch_fits.fewer_parameters import fitted_with_fewer
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Shares of the size that a fit began with.
_SHARES = np.array([0.01, 0.03, 0.1, 0.3, 1.0, 3.0])
# What follows the name of a way where it has several places.
_PLACE = re.compile(r'_\d+$')
# The sizes of all ways are found by turns.
_TURNS = 4


def with_favoured_sizes(pool: RefitPool, model: Hypothesis) -> Hypothesis:
    """Return a model whose free effects are as large in each way as the data favour.

    Where it is fitted so, to first order around where it stands.

    Args:
        pool: who refitted it, and what the nominal model is.
        model: fitted with effects that are free to be others.
    """
    if not model.freed:
        return model
    shares = favoured_shares(model.fit)
    if all(share == 1.0 for share in shares.values()):
        return model
    freed = tuple(_resized(own, shares[own.name]) for own in model.freed)
    scene, evaluator = with_effects(pool.nominal, pool.base, model.added, freed)
    fit = replace(fitted_with_fewer(model.fit, evaluator), is_converged=False)
    return replace(model, scene=scene, evaluator=evaluator, fit=fit, judged=None)


def favoured_shares(fit: Refit) -> Mapping[str, float]:
    """Return by what share of its size each freed parameter of a fit is likeliest, by name."""
    names = fit.parameters.names
    ways: dict[tuple[str, bool, str], list[int]] = {}
    for place, own in enumerate(fit.parameters):
        if own.is_freed:
            ways.setdefault(_way_of(own), []).append(place)
    sight = _Products.of(fit)
    sizes = np.ones(len(names))
    for _ in range(_TURNS):
        before = sizes.copy()
        for places in ways.values():
            levels = np.full(len(_SHARES), -np.inf)
            for number, share in enumerate(_SHARES):
                sizes[places] = share
                levels[number] = sight.level(sizes)
            sizes[places] = _SHARES[int(np.argmax(levels + log_prior(_SHARES)))]
        if np.array_equal(before, sizes):
            break
    return {names[place]: float(sizes[place]) for own in ways.values() for place in own}


def _way_of(own: Parameter) -> tuple[str, bool, str]:
    """Return which amplitudes have a size in common: of one way at all places, or in all poses."""
    if own.posture is not None:
        return own.effect, True, own.amplitude
    return own.effect, False, _PLACE.sub('', own.amplitude)


def _resized(own: Parameter, share: float) -> Parameter:
    std = own.quantity.prior_std
    if std is None:
        return own
    return replace(own, quantity=replace(own.quantity, prior_std=share * std))


class _Products:
    """Inner products of what parameters do, by what is known of them, and of what is seen."""

    def __init__(self, products: FloatArray) -> None:
        """Keep them, the values last, shape (k + 1, k + 1)."""
        self._products = products

    @classmethod
    def of(cls, fit: Refit) -> '_Products':
        """Return those of the patches that were fitted."""
        seen = whiten(fit.groups, Part.FIT)
        offset, precision = fit.prior_offset()
        root = np.linalg.cholesky(np.linalg.inv(precision))
        values = seen.values + seen.jacobian @ offset
        both = np.hstack([seen.jacobian @ root, values[:, None]])
        return cls(both.T @ both)

    def level(self, sizes: FloatArray) -> float:
        """Return the log density, parameters being so many times as large, but for a constant."""
        scaled = sizes[:, None] * self._products[:-1]
        factor = np.linalg.cholesky(np.eye(len(sizes)) + scaled[:, :-1] * sizes)
        told = np.linalg.solve(factor, scaled[:, -1])
        return float(0.5 * told @ told - np.log(np.diag(factor)).sum())
