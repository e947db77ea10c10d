# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which class of causes a gap belongs to, also where the cause itself is in no library.

Each class has a family of smooth fields with a Gaussian prior (`free_fields`). The class whose
fields, learnt from the other poses, predict a pose best is that of the cause.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.diagnosis.patch_fits.free_fields import free_fields
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_gap import closed_fraction, tangent_slack
from diffcal_ros.diagnosis.patches.patch_group import of_the_body, PatchGroup
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import chosen_patches, Part, whiten
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

FloatArray = NDArray[np.float64]

# Sizes of fields that are tried [mm].
_SIZES = np.geomspace(0.03, 30.0, 13)


@dataclass(frozen=True)
class ClassScore:
    """How well the fields of one class predict poses that they have not seen.

    Attributes:
        group: the class.
        prediction: log density of each view given the others, summed, above that without fields.
        size: of the fields [mm].
        closes: share of the held-out root mean square above the floor that they close.
    """

    group: str
    prediction: float
    size: float
    closes: float


def frame_test(evaluator: PatchEvaluator, nominal: Refit) -> tuple[ClassScore, ...]:
    """Score all classes.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.

    Returns:
        The best first; empty where there are fewer than two views to predict one by another.
    """
    if len({group.view for group in nominal.groups}) < 2:
        return ()
    fields = free_fields(evaluator.model, nominal.coordinates)
    classes = list(fields)
    joined = [np.concatenate(own) for own in zip(*fields.values(), strict=True)]
    # The fields are of the body; what a camera's would do to the fixture they do not say.
    groups = of_the_body(evaluator.groups(nominal.coordinates, joined))
    counts = [len(fields[own][0]) for own in classes]
    ends = len(nominal.parameters) + np.cumsum(counts)
    seen = whiten(groups, Part.FIT, tangent_slack(groups), is_apart=True)
    _, precision = regularised_prior(nominal.parameters)
    nuisances = seen.jacobian[:, : len(nominal.parameters)]
    known = np.eye(len(seen)) + nuisances @ np.linalg.solve(precision, nuisances.T)
    nothing = prediction(known, seen.values, seen.views)
    scores = []
    for effect_class, end, count in zip(classes, ends, counts, strict=True):
        columns = np.arange(end - count, end)
        own = seen.jacobian[:, columns]
        likely = [
            prediction(known + size**2 * own @ own.T, seen.values, seen.views) for size in _SIZES
        ]
        best = int(np.argmax(likely))
        size = float(_SIZES[best])
        weights = _weights(known, own, size, seen.values)
        change = _change(precision, nuisances, own, weights, seen.values)
        closes = _closes(groups, columns, weights, change)
        scores.append(ClassScore(effect_class, likely[best] - nothing, size, closes))
    return tuple(sorted(scores, key=lambda score: -score.prediction))


def prediction(covariance: FloatArray, values: FloatArray, views: NDArray[np.int64]) -> float:
    """Return the sum over views of the log density of each given all others.

    Constants that no covariance changes are left out.

    Args:
        covariance: of the values, shape (n, n).
        values: shape (n,).
        views: number of the view of each, shape (n,).
    """
    whole = _log_density(covariance, values)
    total = 0.0
    for view in np.unique(views):
        others = views != view
        total += whole - _log_density(covariance[np.ix_(others, others)], values[others])
    return total


def _log_density(covariance: FloatArray, values: FloatArray) -> float:
    factor, lower = cho_factor(covariance, lower=True)
    volume = 2.0 * float(np.log(np.diag(factor)).sum())
    return -0.5 * (float(values @ cho_solve((factor, lower), values)) + volume)


def _weights(known: FloatArray, own: FloatArray, size: float, values: FloatArray) -> FloatArray:
    """Return the expected weights of the fields, shape (k,)."""
    spread = size**2 * own
    return np.asarray(spread.T @ np.linalg.solve(known + spread @ own.T, values))


def _change(
    precision: FloatArray,
    nuisances: FloatArray,
    own: FloatArray,
    weights: FloatArray,
    values: FloatArray,
) -> FloatArray:
    """Return how the nominal parameters follow what the fields take over, shape (c,)."""
    left = values - own @ weights
    return np.asarray(np.linalg.solve(nuisances.T @ nuisances + precision, nuisances.T @ left))


def _closes(
    groups: Sequence[PatchGroup],
    columns: NDArray[np.int64],
    weights: FloatArray,
    change: FloatArray,
) -> float:
    """Return the share of the gap above the floor that the fields close on held-out patches."""
    before, after, floor = [], [], []
    for group in groups:
        chosen = chosen_patches(group, Part.REPORT)
        slopes = group.patches.jacobian[chosen]
        values = group.patches.values[chosen]
        before.append(values)
        after.append(values - slopes[:, columns] @ weights - slopes[:, : len(change)] @ change)
        noise = group.patches.variances[chosen] + group.mesh[chosen] ** 2
        floor.append(np.sqrt(noise))
    old, new, least = (
        float(np.sqrt(np.mean(np.concatenate(part) ** 2))) for part in (before, after, floor)
    )
    return closed_fraction(old, new, least)
