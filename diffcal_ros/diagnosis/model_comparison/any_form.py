# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well a model does whose effects have about the right form.

No effect of the world has just the form of the library's: a clamp gives way more about one axis,
a rubber stiffens by another law, a lens is a little longer, a camera is moved between two poses.
So a model's discrepancy (Kennedy and O'Hagan 2001) is

    t sum F_i g_i + s sum P_j h_j,    g, h independent and of size one,    t, s half Cauchy,

with F what the effects may do in other forms and P what they may do otherwise in each pose, both
as large as the effects themselves (`form_ways`). All of it is integrated out: g and h with the
parameters, around the fit (Laplace), t and s over a grid. A half Cauchy prior (Gelman, Bayesian
Analysis 1, 2006) believes in small tolerances and lets data say otherwise: an effect that is off
by half in its form is worse than one that is not, and better than another that does not fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from diffcal_ros.diagnosis.model_comparison.form_ways import Ways
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import counted_after, of_the_body, PatchGroup
from diffcal_ros.diagnosis.patches.whitened import chosen_patches, Part, whiten, Whitened
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

FloatArray = NDArray[np.float64]

# Scale of both tolerances, and the shares that are tried: of the form, and from pose to pose.
USUAL = 0.1
OF_FORM = np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2])
BY_POSE = np.array([0.0, 0.1, 0.3, 1.0])
# By which weights of patches and the form of a model that comes near are found.
_TURNS = 3


@dataclass(frozen=True)
class Tolerated:
    """A fitted model, judged with a tolerance for the form of its effects.

    Attributes:
        log_evidence: of the patches that were fitted.
        log_prediction: log density of the patches of the report given those that were fitted.
        fraction: expected tolerance of the form, of what the effects do.
        by_pose: the same from pose to pose.
        left: root mean square of what the likeliest form leaves on the body's patches of the
            report [m].
        chi_square: of the patches that were fitted, with the likeliest tolerances.
        freedom: what noise alone would leave of that.
        exact: log evidence of the exact form on the same patches, at no price for far-off ones.
        coordinates: where parameters are likeliest in the likeliest form, shape (k,).
        covariance: theirs, with all that the form may be instead, shape (k, k).
    """

    log_evidence: float
    log_prediction: float
    fraction: float
    by_pose: float
    left: float
    chi_square: float
    freedom: float
    exact: float
    coordinates: FloatArray
    covariance: FloatArray


def tolerated(fit: Refit, ways: Ways, *, is_brief: bool = False) -> Tolerated:
    """Judge a fitted model.

    Args:
        fit: of it.
        ways: in which its effects may differ from the library's form.
        is_brief: leave out what held-out patches say, which takes most of the time: NaN.
    """
    counted = in_form(fit, ways)
    groups, seen = counted.groups, counted.sight
    levels = seen.levels()
    total = float(logsumexp(levels))
    chances = np.exp(levels - total)
    exact = float(counted.exactly.densities(0.0, np.zeros(1))[0])
    share, fraction = BY_POSE @ chances.sum(axis=1), chances.sum(axis=0) @ OF_FORM
    best = seen.best(levels)
    predicted = left = float('nan')
    if not is_brief:
        both = Sight.of(fit, whiten(groups, Part.ALL), ways.pose_count)
        predicted, left = both.level() - total, _left(fit, groups, best.weights)
    return Tolerated(
        # Of what no form takes near the patches the exact form is as good.
        log_evidence=max(total, exact + float(log_prior(OF_FORM)[0] + log_prior(BY_POSE)[0])),
        log_prediction=predicted,
        fraction=float(fraction),
        by_pose=float(share),
        left=left,
        chi_square=best.chi_square,
        freedom=best.freedom,
        # By forms it owes what they explain, not that they take patches near that are far off.
        exact=exact + 0.5 * float(counted.exactly.prices.sum()),
        coordinates=_led_from(fit, best.weights),
        covariance=best.covariance,
    )


@dataclass(frozen=True)
class _Best:
    """What is found with given tolerances.

    Attributes:
        weights: of all columns, parameters and ways, shape (k,).
        covariance: of the parameters among these, shape (c, c).
        chi_square: of what is left.
        freedom: what noise alone would leave of that.
    """

    weights: FloatArray
    covariance: FloatArray
    chi_square: float
    freedom: float


@dataclass(frozen=True)
class Sight:
    """Patches as they would be if all parameters were what is known of them.

    Attributes:
        values: residuals, whitened, shape (n,).
        own: what parameters do, times the root of what is known of them, shape (n, k).
        root: that root, shape (c, k): from those columns to coordinates.
        by_pose: what the effects may do otherwise in each pose, shape (n, p).
        form: what they may do in other forms, shape (n, f).
        views: number of the view of each, shape (n,).
        volumes: what patches cost that are uneven, see `Whitened`, shape (n,).
        prices: what they cost that are far off, likewise.
        sizes: log determinant of their noise, see `Whitened`, shape (n,).
    """

    values: FloatArray
    own: FloatArray
    root: FloatArray
    by_pose: FloatArray
    form: FloatArray
    views: NDArray[np.int64]
    volumes: FloatArray
    prices: FloatArray
    sizes: FloatArray

    @classmethod
    def of(cls, fit: Refit, seen: Whitened, pose_count: int, gone: Sequence[str] = ()) -> 'Sight':
        """Return it for a fit.

        Args:
            fit: of a model.
            seen: its patches, the tangents of its parameters followed by the ways.
            pose_count: how many ways differ from pose to pose; the others are of the form.
            gone: names of parameters that are taken to zero.
        """
        count = len(fit.coordinates)
        offset, precision = fit.prior_offset()
        is_free = _is_free(fit)
        is_gone = np.isin(fit.parameters.names, gone)
        # What stopped at a bound stays there, and follows nothing.
        offset = np.where(is_free | is_gone, offset, 0.0)
        stay = np.flatnonzero(is_free & ~is_gone)
        covariance = np.linalg.inv(precision[np.ix_(stay, stay)])
        root = np.zeros((count, len(stay)))
        root[stay] = np.linalg.cholesky(0.5 * (covariance + covariance.T))
        own, ways = seen.jacobian[:, :count] @ root, seen.jacobian[:, count:]
        return cls(
            values=seen.values + seen.jacobian[:, :count] @ offset,
            own=own,
            root=root,
            by_pose=ways[:, :pose_count],
            form=ways[:, pose_count:],
            views=seen.views,
            volumes=seen.volumes,
            prices=seen.tolerances,
            sizes=seen.sizes,
        )

    def without(self, view: int) -> 'Sight':
        """Return it without one of the views."""
        others = np.flatnonzero(self.views != view)
        return Sight(
            self.values[others],
            self.own[others],
            self.root,
            self.by_pose[others],
            self.form[others],
            self.views[others],
            self.volumes[others],
            self.prices[others],
            self.sizes[others],
        )

    def level(self) -> float:
        """Return the log density, both tolerances integrated out."""
        return float(logsumexp(self.levels()))

    @property
    def noise(self) -> float:
        """Log determinant of the noise: what a density costs by its size, which levels leave out.

        Models are held against one another by the same noise. Sizes of noise are not.
        """
        return float(self.sizes.sum())

    def levels(self) -> FloatArray:
        """Return the log density with each pair of tolerances and the log of its prior, (b, f)."""
        return np.array(
            [
                chance + log_prior(OF_FORM) + self.densities(share, OF_FORM)
                for share, chance in zip(BY_POSE, log_prior(BY_POSE), strict=True)
            ]
        )

    def densities(self, share: float, fractions: FloatArray) -> FloatArray:
        """Return log densities with one tolerance from pose to pose and several of the form."""
        sizes = np.repeat((1.0, share), (self.own.shape[1], self.by_pose.shape[1]))
        count = len(sizes)
        scaled = sizes[:, None] * self._products[:count]
        factor = np.linalg.cholesky(np.eye(count) + scaled[:, :count] * sizes)
        # Of form and values, less what is explained by those.
        told = solve_triangular(factor, scaled[:, count:], lower=True, check_finite=False)
        rest = self._products[count:, count:] - told.T @ told
        sizes, turns = np.linalg.eigh(rest[:-1, :-1])
        pulls = (turns.T @ rest[:-1, -1]) ** 2
        squares = fractions[:, None] ** 2
        grown = 1.0 + squares * np.maximum(sizes, 0.0)
        distance = rest[-1, -1] - (squares * pulls / grown).sum(axis=1)
        volume = 2.0 * np.log(np.diag(factor)).sum() + np.log(grown).sum(axis=1)
        cost = volume + self.volumes.sum() + self.prices.sum()
        return np.asarray(-0.5 * (distance + cost))

    @cached_property
    def _products(self) -> FloatArray:
        """Inner products of all columns, the values last: there are fewer than patches."""
        both = np.hstack([self.own, self.by_pose, self.form, self.values[:, None]])
        return both.T @ both

    def best(self, levels: FloatArray) -> _Best:
        """Return what is found with the likeliest tolerances; levels as by `levels`."""
        row, column = np.unravel_index(int(np.argmax(levels)), levels.shape)
        return self.at(float(BY_POSE[row]), float(OF_FORM[column]))

    def at(self, share: float, fraction: float) -> _Best:
        """Return what is found with two given tolerances."""
        counts = self.own.shape[1], self.by_pose.shape[1], self.form.shape[1]
        sizes = np.repeat((1.0, share, fraction), counts)
        products = self._products[:-1, :-1] * np.outer(sizes, sizes)
        inverse = np.linalg.inv(np.eye(len(sizes)) + products)
        weights = inverse @ (sizes * self._products[:-1, -1])
        own, ways = np.split(weights, [counts[0]])
        left = self.values - np.hstack([self.own, self.by_pose, self.form]) @ (sizes * weights)
        return _Best(
            np.concatenate([self.root @ own, sizes[counts[0] :] * ways]),
            self.root @ inverse[: counts[0], : counts[0]] @ self.root.T,
            float(left @ left),
            # Residuals are the inverse covariance times what is seen, whose covariance is known.
            float(len(self.values) - len(sizes) + np.trace(inverse)),
        )

    @property
    def known_volume(self) -> float:
        """Log determinant of the covariance by noise and what parameters may be."""
        products = self.own.T @ self.own
        return float(np.linalg.slogdet(np.eye(len(products)) + products)[1])


def log_prior(shares: FloatArray) -> FloatArray:
    """Return the log of how much a half Cauchy prior believes in each share, (n,)."""
    borders = np.concatenate([[0.0], 0.5 * (shares[1:] + shares[:-1]), [np.inf]])
    return np.asarray(np.log(np.diff(2.0 / np.pi * np.arctan(borders / USUAL))))


@dataclass(frozen=True)
class InForm:
    """Patches of a fitted model, counted by what the likeliest form leaves of them.

    Attributes:
        groups: with tangents of parameters and ways.
        exactly: those that were fitted, counted by how far off the fit leaves them.
        sight: those, counted by what the form leaves of them.
    """

    groups: list[PatchGroup]
    exactly: Sight
    sight: Sight


def in_form(fit: Refit, ways: Ways, gone: Sequence[str] = ()) -> InForm:
    """Count patches of a fitted model: what the likeliest form leaves far off counts less.

    In the library's form a patch may be far off and count little. Counted so in a form that takes
    it where it is seen, it would make forms explain the more the farther off a model is. Weights
    and form are found by turns (iteratively reweighted least squares).

    Args:
        fit: of a model.
        ways: in which its effects may differ from the library's form.
        gone: names of parameters that are taken to zero.
    """
    groups = ways.joined(fit.groups)
    seen = whiten(groups, Part.FIT)
    sight = exactly = Sight.of(fit, seen, ways.pose_count, gone)
    for _ in range(_TURNS):
        if not seen.has_far_off:
            break
        step = _step(fit, sight.best(sight.levels()).weights, gone)
        groups = counted_after(groups, step)
        seen = whiten(groups, Part.FIT)
        sight = Sight.of(fit, seen, ways.pose_count, gone)
    return InForm(groups, exactly, sight)


def led_by_form(fit: Refit, ways: Ways, gone: Sequence[str] = ()) -> FloatArray:
    """Return where parameters are likeliest if effects have the form that the data favour, (k,).

    Args:
        fit: of a model, around which all is linear.
        ways: in which its effects may differ from the library's form.
        gone: names of parameters that are taken to zero.
    """
    seen = in_form(fit, ways, gone).sight
    found = _led_from(fit, seen.best(seen.levels()).weights)
    return np.where(np.isin(fit.parameters.names, gone), 0.0, found)


def _led_from(fit: Refit, weights: FloatArray) -> FloatArray:
    """Return where parameters are with weights as of `_Best`, within their bounds, (k,)."""
    found = fit.coordinates + _step(fit, weights)[: len(fit.coordinates)]
    return np.clip(found, *fit.parameters.bounds())


def _step(fit: Refit, weights: FloatArray, gone: Sequence[str] = ()) -> FloatArray:
    """Return weights, counted from where parameters are likeliest beforehand, from the fit."""
    offset, _ = fit.prior_offset()
    step = weights.copy()
    moves = _is_free(fit) | np.isin(fit.parameters.names, gone)
    step[: len(offset)] -= np.where(moves, offset, 0.0)
    return step


def _is_free(fit: Refit) -> NDArray[np.bool_]:
    """Tell which parameters are between their bounds, shape (k,)."""
    lower, upper = fit.parameters.bounds()
    return np.asarray((fit.coordinates > lower) & (fit.coordinates < upper))


def _left(fit: Refit, groups: Sequence[PatchGroup], weights: FloatArray) -> float:
    """Return what is left on the body's patches of the report [m], root mean square.

    Args:
        fit: of a model.
        groups: with tangents of parameters and ways.
        weights: of both, from where the parameters are likeliest beforehand, shape (k,).
    """
    step = _step(fit, weights)
    left = [
        group.patches.values[chosen] - group.patches.jacobian[chosen] @ step
        for group in of_the_body(groups)
        for chosen in (chosen_patches(group, Part.REPORT),)
    ]
    values = np.concatenate(left) if left else np.zeros(0)
    return float(np.sqrt(np.mean(values**2))) if len(values) else float('nan')
