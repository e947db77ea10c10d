# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well a model does whose effect has about the right form.

No effect of the world has just the form of the library's: a clamp gives way more about one axis,
a rubber stiffens by another law, a lens is a little longer. What such an effect does is the
library's effect times a function that is near one and varies slowly, over the body or over the
image. So a model's discrepancy (Kennedy and O'Hagan 2001) is

    d(x) t g(x),    g a Gaussian process of size one,    t half normal,

with d what the effect itself does to the patches, and t its tolerance. Both are integrated out: g
with the parameters, around their optimum (Laplace), and t over a grid. A second effect must then
explain what the first one's form may not.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.diagnosis.model_comparison.form_ways import Places, places_of
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import full_names, FullName, PatchGroup
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
import numpy as np
from numpy.typing import NDArray
from scipy.special import erf, logsumexp

FloatArray = NDArray[np.float64]

# Usual tolerance: a share of what the effect does. Those that are tried.
_USUAL = 0.1
_FRACTIONS = np.array([0.0, 0.02, 0.05, 0.1, 0.17, 0.25])


@dataclass(frozen=True)
class Tolerated:
    """A fitted model, judged with a tolerance for the form of its effects.

    Attributes:
        log_evidence: of the patches that were fitted; of the exact form it is the fit's own.
        log_prediction: log density of the patches of the report given those that were fitted.
        fraction: expected tolerance, of what the effects do.
        size: root mean square of what it lets the patches move [m].
        chi_square: of the patches that were fitted, with the most likely tolerance.
        exact: log evidence of the exact form, on the same patches.
        patch_count: how many these are.
    """

    log_evidence: float
    log_prediction: float
    fraction: float
    size: float
    chi_square: float
    exact: float
    patch_count: int


def tolerated(
    model: ForwardModel,
    fit: Refit,
    nominal: Refit,
    effect_classes: Sequence[str],
    points: Sequence[FloatArray],
) -> Tolerated:
    """Judge a fitted model.

    Args:
        model: with its effects.
        fit: of it.
        nominal: fit of the model without.
        effect_classes: of the effects; what a sensor's error is times varies over the image.
        points: nodes of the body in each view where its model without the effects stands [m],
            camera frame, shape (N, 3) each: near enough for what varies over half the body.
    """
    done = _done_by(fit, nominal)
    ways = _ways(effect_classes, done, places_of(model, fit.groups, points))
    groups = [
        replace(b, patches=replace(b.patches, jacobian=np.hstack([b.patches.jacobian, w])))
        for b, w in zip(fit.groups, ways, strict=True)
    ]
    prior = np.log(np.diff(erf(_borders() / (np.sqrt(2.0) * _USUAL))))
    seen, both = (_levels(fit, groups, part) for part in (Part.FIT, Part.ALL))
    levels = prior + seen.levels
    chances = np.exp(levels - logsumexp(levels))
    fraction = float(chances @ _FRACTIONS)
    moved = np.concatenate(done) if done else np.zeros(0)
    return Tolerated(
        log_evidence=float(logsumexp(levels)),
        log_prediction=float(logsumexp(prior + both.levels) - logsumexp(levels)),
        fraction=fraction,
        size=fraction * float(np.sqrt(np.mean(moved**2))) if len(moved) else 0.0,
        chi_square=float(seen.chi_squares[int(np.argmax(levels))]),
        exact=fit.log_evidence,
        patch_count=fit.patch_count,
    )


def _borders() -> FloatArray:
    middles = 0.5 * (_FRACTIONS[1:] + _FRACTIONS[:-1])
    return np.concatenate([[0.0], middles, [np.inf]])


def _done_by(fit: Refit, nominal: Refit) -> list[FloatArray]:
    """Return how far the effects move each patch of each group beside what the nominal fit did."""
    before: dict[FullName, float] = {}
    for group in nominal.groups:
        before.update(zip(full_names([group]), group.patches.values.tolist(), strict=True))
    found = []
    for group in fit.groups:
        names, after = full_names([group]), group.patches.values
        found.append(
            np.array([before.get(name, v) - v for name, v in zip(names, after, strict=True)])
        )
    return found


def _ways(
    effect_classes: Sequence[str], done: Sequence[FloatArray], places: Sequence[Places]
) -> list[FloatArray]:
    """Return what the functions of one tolerance's size do to the patches of each group [m]."""
    kinds = dict.fromkeys('sensor' if own == 'sensor' else 'body' for own in effect_classes)
    size = 1.0 / np.sqrt(max(len(kinds), 1))
    return [
        np.hstack([place.times(size * moved, place.functions(kind)) for kind in kinds])
        for moved, place in zip(done, places, strict=True)
    ]


@dataclass(frozen=True)
class _Levels:
    """By tolerance: log evidence, and chi-square of what is left."""

    levels: FloatArray
    chi_squares: FloatArray


def _levels(fit: Refit, groups: Sequence[PatchGroup], part: Part) -> _Levels:
    seen = whiten(groups, part)
    offset, precision = fit.prior_offset()
    count = len(fit.coordinates)
    lower, upper = fit.parameters.bounds()
    # What stopped at a bound does not follow.
    free = np.flatnonzero((fit.coordinates > lower) & (fit.coordinates < upper))
    products = seen.jacobian.T @ seen.jacobian
    pull = seen.jacobian.T @ seen.values
    pull[:count] -= precision @ offset
    cost = 0.5 * (seen.chi_square + float(offset @ precision @ offset))
    levels, chi_squares = [], []
    for fraction in _FRACTIONS:
        size = count if fraction == 0.0 else len(pull)
        prior = np.eye(size) / (fraction**2 if fraction > 0.0 else 1.0)
        prior[:count, :count] = precision
        information = products[:size, :size] + prior
        moving = np.concatenate([free, np.arange(count, size)])
        own = information[np.ix_(moving, moving)]
        step = np.linalg.solve(own, pull[moving])
        left = seen.values - seen.jacobian[:, moving] @ step
        volumes = np.linalg.slogdet(information)[1] - np.linalg.slogdet(prior)[1]
        levels.append(-cost + 0.5 * float(pull[moving] @ step) - 0.5 * volumes)
        chi_squares.append(float(left @ left))
    return _Levels(np.array(levels), np.array(chi_squares))
