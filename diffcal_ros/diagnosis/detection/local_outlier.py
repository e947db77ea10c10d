# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A gap in one place of the body, which says nothing about the rest of it.

What is far off on a few patches that lie together may be something before the body, an edge of the
fixture, a fault of the surface or of the sensor there; or the body itself, which bends or stiffens
most at an end. The two differ at the place's border: a body is continuous, a thing before it ends.
So two models of the gap are compared by their evidence, parameters integrated out in both:

- nothing is wrong with the body, and the patches of one place have an error of their own;
- the body moves, in each view by a smooth field of its own (a Gaussian process of the place on the
  body at rest, of any size), or as an effect of the library moves it.

A place is left out where the first is likelier by more than is called very strong evidence (Kass
and Raftery, *Bayes factors*, J. Am. Stat. Assoc. 90, 1995), the number of places that were looked
at paid for. It is told, and the rest is judged without it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.diagnosis.patch_fits.linear_evidence import LinearEvidence
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.residual_location import (
    nearest_nodes,
    PART_NAMES,
    parts_of_nodes,
)
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import names_of, of_the_body, PatchGroup, PatchName
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import library_groups
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A place is what lies so near one patch, as a share of the body's diagonal, and few patches.
_REACH = 0.15
_FEW = 0.15
# Only around patches that are so many standard deviations off is one looked for, and around those
# that are farthest off.
_OFF, _MOST_MIDDLES = 2.0, 50
# Of two models' evidences, logarithm of a ratio that is very strong.
_VERY_STRONG = 5.0
# How far a thing may be before the body, and a body move [m]; all are as likely.
_THING_SIZES = np.geomspace(0.0005, 0.030, 6)
_BODY_SIZES = np.geomspace(0.0001, 0.010, 7)
# Of an effect, in usual sizes.
_EFFECT_SIZES = np.array([0.3, 1.0, 3.0])
# Over which the body's movement changes, as shares of its diagonal.
_LENGTHS = (0.25, 0.5)
# From where on an end bends by itself, as shares of the way from clamp to tip.
_BENDS_FROM = (0.5, 0.75)
# Of the variance of a thing's error, what all its patches in one view have in common.
_COMMON = 0.5
# Directions that hardly move are left out, as a share of the largest.
_LEAST = 1e-6


@dataclass(frozen=True)
class LocalOutlier:
    """Patches in one place that hold most of the gap.

    Attributes:
        patches: their names.
        size: root mean square of their residuals [m].
        where: part of the body, in words.
    """

    patches: frozenset[PatchName]
    size: float
    where: str

    @property
    def sentence(self) -> str:
        """Tell what was left out."""
        return (
            f'{len(self.patches)} patches in one place {self.where} are off by '
            f'{1e3 * self.size:.1f} mm, and what lies around them is not: something before the '
            'body, or its edge there; they were left out'
        )


def find_local_outlier(evaluator: PatchEvaluator, fit: Refit) -> LocalOutlier | None:
    """Return the place whose patches no movement of the body explains; None where none is so.

    Args:
        evaluator: of the model.
        fit: of it, with all patches.
    """
    model = evaluator.model
    groups = [group for group in of_the_body(fit.groups) if len(group.patches.values)]
    if not groups:
        return None
    nodes = _nodes(model, fit, groups)
    rest = model.body(model.observations[0]).discretisation.rest_nodes
    nothing = LinearEvidence.of_fit(fit, groups)
    offsets = nothing.offsets()
    middles = np.argsort(-offsets, kind='stable')[
        : min(_MOST_MIDDLES, int((offsets > _OFF).sum()))
    ]
    if not len(middles):
        return None
    places = _places(rest, nodes, groups, middles)
    gains = np.array(
        [nothing.gain(_thing(place, groups), _THING_SIZES, place) for place in places]
    )
    likeliest = int(gains.argmax())
    lead = float(gains[likeliest] - np.log(len(places))) - _VERY_STRONG
    if lead < 0.0 or lead < _gain_of_body(evaluator, fit, nothing, rest, nodes):
        return None
    place = places[likeliest]
    names = names_of(groups)
    values = np.concatenate([group.patches.values for group in groups])
    part = parts_of_nodes(model, groups[0].view)[nodes[place]]
    return LocalOutlier(
        patches=frozenset(names[number] for number in place),
        size=float(np.sqrt(np.mean(values[place] ** 2))),
        where=PART_NAMES[int(np.median(part))],
    )


def _nodes(model: ForwardModel, fit: Refit, groups: Sequence[PatchGroup]) -> IntArray:
    """Return the node that is seen nearest to each patch, shape (n,)."""
    views, seen = model.views(fit.coordinates), model.observations
    return np.concatenate(
        [nearest_nodes(own, views[own.view].points, seen[own.view].camera) for own in groups]
    )


def _places(
    rest: FloatArray, nodes: IntArray, groups: Sequence[PatchGroup], middles: IntArray
) -> list[IntArray]:
    """Return places of all sizes around some patches, in one view and in all.

    Args:
        rest: nodes of the body at rest, where the same ones lie in one place in every posture [m],
            shape (N, 3).
        nodes: which is nearest to each patch, shape (n,).
        groups: of the patches.
        middles: patches that may be in the middle of one, shape (m,).
    """
    reach = _REACH * float(np.linalg.norm(np.ptp(rest, axis=0)))
    most = max(int(_FEW * len(nodes)), 1)
    views = np.concatenate([np.full(len(b.patches.values), b.view) for b in groups])
    found: dict[tuple[int, ...], None] = {}
    for middle in middles:
        apart = np.linalg.norm(rest[nodes] - rest[nodes[middle]], axis=1)
        # Of patches at one node the middle itself comes first.
        apart[middle] = -1.0
        order = np.argsort(apart, kind='stable')
        order = order[apart[order] <= reach]
        for own in (order, order[views[order] == views[middle]]):
            for count in _counts(min(len(own), most)):
                found.setdefault(tuple(sorted(own[:count].tolist())))
    return [np.array(place) for place in found]


def _counts(most: int) -> Iterator[int]:
    """Yield 1, 2, 4 and so on, and the most there may be."""
    count = 1
    while count < most:
        yield count
        count *= 2
    yield most


def _thing(place: IntArray, groups: Sequence[PatchGroup]) -> FloatArray:
    """Return errors of size one that what lies before a place makes, as columns (p, k)."""
    numbers = np.concatenate([np.full(len(b.patches.values), n) for n, b in enumerate(groups)])
    own = numbers[place]
    common = (own[:, None] == np.unique(own)).astype(float)
    return np.hstack([np.sqrt(_COMMON) * common, np.sqrt(1.0 - _COMMON) * np.eye(len(place))])


def _gain_of_body(
    evaluator: PatchEvaluator,
    fit: Refit,
    nothing: LinearEvidence,
    rest: FloatArray,
    nodes: IntArray,
) -> float:
    """Return how much likelier the residuals are with movements of the body than without."""
    listed = candidates(evaluator.model.scene)
    names, wide = library_groups(evaluator, fit.coordinates, listed)
    tangents = _columns(wide, len(names))
    ways = [
        tangents[:, [names.index(name) for name in one.names]] * one.scales
        for one in listed
        if set(one.names) <= set(names)
    ]
    gains = [nothing.gain(columns, _EFFECT_SIZES) for columns in ways]
    along = evaluator.model.effects.axes(0).fraction(rest)
    slopes, seen_along = _seen_along(evaluator, fit, along)
    views = np.concatenate([np.full(len(b.patches.values), b.view) for b in of_the_body(wide)])
    diagonal = float(np.linalg.norm(np.ptp(rest, axis=0)))
    apart = np.linalg.norm(rest[nodes][:, None] - rest[nodes], axis=-1)
    kernels = [np.exp(-((apart / (length * diagonal)) ** 2)) for length in _LENGTHS]
    kernels += [_bending(seen_along, begins) for begins in _BENDS_FROM]
    gains += [nothing.gain(_fields(slopes, kernel, views), _BODY_SIZES) for kernel in kernels]
    return float(np.logaddexp.reduce(gains) - np.log(len(gains)))


def _seen_along(
    evaluator: PatchEvaluator, fit: Refit, along: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return how patches follow movements along the camera's axes, and where on the body they lie.

    Args:
        evaluator: of the model.
        fit: of it.
        along: share of the way from clamp to tip of each node, shape (N,).

    Returns:
        Slopes, shape (n, 3), and the mean of that share over what is seen in each patch, (n,).
    """
    shifts = np.tile(np.eye(3)[:, None], (1, len(along), 1))
    moved = np.concatenate([shifts, shifts * along[:, None]])
    count = len(evaluator.model.observations)
    columns = _columns(evaluator.groups(fit.coordinates, [moved] * count), 6)
    slopes, weighted = columns[:, :3], columns[:, 3:]
    # Along the axis that moves a patch most.
    clearest = np.abs(slopes).argmax(axis=1)[:, None]
    means = np.take_along_axis(weighted, clearest, 1) / np.take_along_axis(slopes, clearest, 1)
    return slopes, means[:, 0]


def _columns(groups: Sequence[PatchGroup], count: int) -> FloatArray:
    """Return the last columns of the body's patches, shape (n, count)."""
    return np.concatenate(
        [group.patches.jacobian for group in of_the_body(groups) if len(group.patches.values)]
    )[:, -count:]


def _bending(along: FloatArray, begins: float) -> FloatArray:
    """Return the covariance of how far a body stands off that bends anywhere from a place on.

    Its curvature is white noise, so that the way is an integrated Wiener process (Wahba, J. R.
    Stat. Soc. B 40, 1978), here of size one at the tip.

    Args:
        along: share of the way from clamp to tip of each patch, shape (n,).
        begins: from where on it bends, likewise.
    """
    beyond = np.clip((along - begins) / (1.0 - begins), 0.0, 1.0)
    near, far = np.minimum.outer(beyond, beyond), np.maximum.outer(beyond, beyond)
    return np.asarray(0.5 * near**2 * (3.0 * far - near))


def _fields(slopes: FloatArray, kernel: FloatArray, views: IntArray) -> FloatArray:
    """Return what random movements, others in each view, do to the patches, shape (n, k).

    Args:
        slopes: what moves along the camera's axes do to each patch, shape (n, 3).
        kernel: covariance of the movements along each axis, shape (n, n).
        views: number of the view of each, shape (n,).
    """
    found = []
    for view in np.unique(views):
        own = np.flatnonzero(views == view)
        covariance = kernel[np.ix_(own, own)] * (slopes[own] @ slopes[own].T)
        values, turns = np.linalg.eigh(covariance)
        kept = values > _LEAST * values.max()
        columns = np.zeros((len(views), int(kept.sum())))
        columns[own] = turns[:, kept] * np.sqrt(values[kept])
        found.append(columns)
    return np.hstack(found)
