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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import re

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.any_form import log_prior
from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.promised_fits import fitted_as_promised
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.patch_fits.fewer_parameters import fitted_with_fewer
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import counted_after
from diffcal_ros.diagnosis.patches.whitened import Part, whiten, Whitened
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, solve_triangular

FloatArray = NDArray[np.float64]

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


def refitted(pool: RefitPool, requests: Sequence[RefitRequest]) -> list[Hypothesis]:
    """Return refits, those that can be simulated, whose free effects are as large as data favour.

    Args:
        pool: who refit, and what the nominal model is.
        requests: models to refit.
    """
    found = pool.refit_all(requests)
    return fitted_as_promised(pool, found, [with_favoured_sizes(pool, model) for model in found])


def favoured_shares(fit: Refit) -> Mapping[str, float]:
    """Return by what share of its size each freed parameter of a fit is likeliest, by name.

    Patches that are far off count less, by what a form of these sizes leaves of them: both are
    found by turns, as in `any_form.in_form`.
    """
    names, ways = fit.parameters.names, _ways_of(fit)
    sizes, groups = np.ones(len(names)), list(fit.groups)
    for _ in range(_TURNS):
        seen = whiten(groups, Part.FIT)
        products, before = Products.of(fit, seen), sizes
        sizes = _likeliest(products, ways, sizes)
        if np.array_equal(before, sizes) or not seen.has_far_off:
            break
        groups = counted_after(groups, products.step(sizes))
    return {names[place]: float(sizes[place]) for own in ways for place in own}


def _ways_of(fit: Refit) -> list[list[int]]:
    """Return the places of the freed parameters of a fit, those of one way together."""
    ways: dict[tuple[str, bool, float, str], list[int]] = {}
    for place, own in enumerate(fit.parameters):
        if own.is_freed:
            ways.setdefault(_way_of(own), []).append(place)
    return list(ways.values())


def _likeliest(
    products: 'Products', ways: Sequence[Sequence[int]], start: FloatArray
) -> FloatArray:
    """Return the likeliest sizes, those of each way found beside all others by turns, (k,)."""
    sizes, believed = start.copy(), log_prior(_SHARES)
    for _ in range(_TURNS):
        before = sizes.copy()
        for places in ways:
            levels = np.zeros(len(_SHARES))
            for number, share in enumerate(_SHARES):
                sizes[places] = share
                levels[number] = products.level(sizes)
            sizes[places] = _SHARES[int(np.argmax(levels + believed))]
        if np.array_equal(before, sizes):
            break
    return sizes


def _way_of(own: Parameter) -> tuple[str, bool, float, str]:
    """Return which amplitudes have a size in common.

    Those of one way at all places, in all poses, or around all knots as far apart.
    """
    if own.is_in_all:
        return own.effect, False, 0.0, _PLACE.sub('', own.amplitude)
    spacing = 0.0 if own.knot is None else own.knot.spacing
    return own.effect, own.posture is not None, spacing, own.amplitude


def _resized(own: Parameter, share: float) -> Parameter:
    std = own.quantity.prior_std
    if std is None:
        return own
    return replace(own, quantity=replace(own.quantity, prior_std=share * std))


@dataclass(frozen=True)
class Products:
    """Inner products of what parameters do, by what is known of them, and of what is seen.

    Attributes:
        products: the values last, shape (k + 1, k + 1).
        root: from columns to coordinates, shape (k, k).
        offset: of the fit from where parameters are likeliest beforehand, shape (k,).
    """

    products: FloatArray
    root: FloatArray
    offset: FloatArray

    @classmethod
    def of(cls, fit: Refit, seen: Whitened) -> 'Products':
        """Return those of a fit and its patches."""
        offset, precision = fit.prior_offset()
        root = np.linalg.cholesky(np.linalg.inv(precision))
        values = seen.values + seen.jacobian @ offset
        both = np.hstack([seen.jacobian @ root, values[:, None]])
        return cls(both.T @ both, root, offset)

    def level(self, sizes: FloatArray) -> float:
        """Return the log density, parameters being so many times as large, but for a constant."""
        factor, scaled = self._factor(sizes)
        told = solve_triangular(factor, scaled[:, -1], lower=True, check_finite=False)
        return float(0.5 * told @ told - np.log(np.diag(factor)).sum())

    def step(self, sizes: FloatArray) -> FloatArray:
        """Return the step from the fit to where parameters of these sizes are likeliest, (k,)."""
        factor, scaled = self._factor(sizes)
        weights = sizes * cho_solve((factor, True), scaled[:, -1])
        # Residuals fall by what parameters do.
        return np.asarray(self.root @ weights - self.offset)

    def covariance(self, sizes: FloatArray) -> FloatArray:
        """Return the covariance of coordinates by parameters of these sizes, shape (k, k)."""
        factor, _ = self._factor(sizes)
        half = solve_triangular(factor, (self.root * sizes).T, lower=True, check_finite=False)
        return np.asarray(half.T @ half)

    def _factor(self, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
        scaled = sizes[:, None] * self.products[:-1]
        information = np.eye(len(sizes)) + scaled[:, :-1] * sizes
        return np.asarray(np.linalg.cholesky(information), dtype=np.float64), scaled
