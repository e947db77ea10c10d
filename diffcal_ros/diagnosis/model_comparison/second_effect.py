# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a second effect adds that no form of the first one explains.

Two effects of the library's form can imitate one of another form: a camera off along its axis
with a bias of depth is a lens that is longer; an error of depth that drifts from pose to pose is,
in part, a camera that is off. So each of a pair is held against the other alone in whatever form
it may have: off by a tenth usually, by half at times (its tolerance is half Cauchy), in a picture
whose own form may be off where the camera is. And what really is there is there in every pose: a
second effect must tell each pose from the others better than the first one alone does.

All is linear around a fit. Around that of the pair the first alone stands where it would be led
by a fit that knows what its form may be; from where it came to rest in the library's exact form it
may be far.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.model_comparison.form_ways import Places, places_of
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.shared_patches import on_shared_patches
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.whitened import Part, whiten, Whitened
from diffcal_ros.diagnosis.screening.candidates import Candidate
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import logsumexp

FloatArray = NDArray[np.float64]

# A second effect must be better by so much log evidence, per unit of noise scale.
PAIR_GAIN = 8.0
# Scale of both tolerances, and the shares that are tried: of the form, and of the amplitude from
# pose to pose.
_USUAL = 0.1
_OF_FORM = np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8])
_BY_POSE = np.array([0.0, 0.1, 0.3, 1.0])


@dataclass(frozen=True)
class Explained:
    """How well some effects explain patches, in whatever form they may have.

    Attributes:
        log_evidence: of the patches that were fitted.
        log_transfer: log density of each view given all others, summed; 0 of a single view.
    """

    log_evidence: float
    log_transfer: float

    def above(self, others: Sequence['Explained']) -> 'Explained':
        """Return by how much it is above the best of others, each figure for itself."""
        return Explained(
            self.log_evidence - max(other.log_evidence for other in others),
            self.log_transfer - max(other.log_transfer for other in others),
        )


def most_gain(hypothesis: Hypothesis) -> float:
    """Return how much log evidence a further effect could gain that costs nothing.

    It would leave noise alone, pull no parameter from where it is likely, and need no tolerance
    for the form of the effects that are there, which has gained some of that before.
    """
    fit = hypothesis.fit
    noise = fit.patch_count - len(fit.coordinates)
    left = fit.chi_square - noise + fit.prior_chi_square
    judged = hypothesis.judged
    gained = 0.0 if judged is None else judged.log_evidence - judged.exact
    return 0.5 * left - gained


def most_added(one: Hypothesis, points: Sequence[FloatArray]) -> float:
    """Return how much log evidence a second effect could add that leaves noise alone.

    Args:
        one: a model with a single effect.
        points: nodes of the body in each view [m], camera frame, shape (N, 3) each.
    """
    fit = one.fit
    places = places_of(one.evaluator.model, fit.groups, points)
    alone = explained(fit, one.added, one.added, places, in_any_form=True)
    seen = whiten(fit.groups, Part.FIT)
    noise = len(seen) - len(fit.coordinates)
    known = _Sight.of(fit, seen, range(len(fit.coordinates)), 0).known
    return -0.5 * (noise + float(np.linalg.slogdet(known)[1])) - alone.log_evidence


def second_adds(one: Hypothesis, two: Hypothesis, points: Sequence[FloatArray]) -> Explained:
    """Return what a pair explains above each of its effects, and above the best single one.

    A single view tells nothing of others; what is transferred to them is taken for enough then.

    Args:
        one: the best model with a single effect.
        two: the model with two.
        points: nodes of the body in each view [m], camera frame, shape (N, 3) each.
    """
    one, two = on_shared_patches([one, two])
    places = places_of(two.evaluator.model, two.fit.groups, points)
    both = explained(two.fit, two.added, two.added, places)
    alone = [explained(two.fit, two.added, [own], places, in_any_form=True) for own in two.added]
    there = places_of(one.evaluator.model, one.fit.groups, points)
    alone.append(explained(one.fit, one.added, one.added, there, in_any_form=True))
    found = both.above(alone)
    return found if places[0].view_count > 1 else replace(found, log_transfer=np.inf)


def explained(
    fit: Refit,
    added: Sequence[Candidate],
    kept: Sequence[Candidate],
    places: Sequence[Places],
    *,
    in_any_form: bool = False,
) -> Explained:
    """Return how well some of a model's effects explain the patches, around its fit.

    Args:
        fit: of the model.
        added: its effects.
        kept: those that stay; the others are taken to zero.
        places: of the groups of the fit.
        in_any_form: their amplitudes may differ from pose to pose, and so may the picture's form.
    """
    by_pose = _by_pose(fit, kept if in_any_form else (), places)
    of_form = _of_form(fit, kept, places, with_picture=in_any_form)
    groups = [
        replace(b, patches=replace(b.patches, jacobian=np.hstack([b.patches.jacobian, *own])))
        for b, *own in zip(fit.groups, by_pose, of_form, strict=True)
    ]
    pose_count = by_pose[0].shape[1]
    gone = {name for candidate in added if candidate not in kept for name in candidate.names}
    stay = [n for n, name in enumerate(fit.parameters.names) if name not in gone]
    whole = _Sight.of(fit, whiten(groups, Part.FIT), stay, pose_count).level()
    apart = _Sight.of(fit, whiten(groups, Part.FIT, is_apart=True), stay, pose_count)
    views = np.unique(apart.views)
    transfer = 0.0
    if len(views) > 1:
        every = apart.level()
        transfer = sum(every - apart.without(view).level() for view in views)
    return Explained(whole, transfer)


@dataclass(frozen=True)
class _Sight:
    """Patches as they would be if all parameters were what is known of them.

    Attributes:
        values: residuals, whitened, shape (n,).
        known: their covariance by noise and what parameters and effects may be, shape (n, n).
        by_pose: what amplitudes add to that which are off by themselves in each pose, (n, n).
        form: what a form adds that is off by all that an effect does, shape (n, n).
        views: number of the view of each, shape (n,).
    """

    values: FloatArray
    known: FloatArray
    by_pose: FloatArray
    form: FloatArray
    views: NDArray[np.int64]

    @classmethod
    def of(cls, fit: Refit, seen: Whitened, stay: Sequence[int], pose_count: int) -> '_Sight':
        """Return it for a fit of which some parameters stay, and the others are zero."""
        count = len(fit.coordinates)
        offset, precision = fit.prior_offset()
        own, ways = seen.jacobian[:, stay], seen.jacobian[:, count:]
        spread = np.linalg.solve(precision[np.ix_(stay, stay)], own.T)
        return cls(
            seen.values + seen.jacobian[:, :count] @ offset,
            np.eye(len(seen)) + own @ spread,
            ways[:, :pose_count] @ ways[:, :pose_count].T,
            ways[:, pose_count:] @ ways[:, pose_count:].T,
            seen.views,
        )

    def without(self, view: int) -> '_Sight':
        """Return it without one of the views."""
        others = np.flatnonzero(self.views != view)
        square = np.ix_(others, others)
        return _Sight(
            self.values[others],
            self.known[square],
            self.by_pose[square],
            self.form[square],
            self.views[others],
        )

    def level(self) -> float:
        """Return the log density, both tolerances integrated out."""
        found = []
        for share, chance in zip(_BY_POSE, _log_prior(_BY_POSE), strict=True):
            known = self.known + share**2 * self.by_pose
            levels = [_log_density(known + t**2 * self.form, self.values) for t in _OF_FORM]
            found.append(chance + _log_prior(_OF_FORM) + np.array(levels))
        return float(logsumexp(np.concatenate(found)))


def _log_prior(shares: FloatArray) -> FloatArray:
    borders = np.concatenate([[0.0], 0.5 * (shares[1:] + shares[:-1]), [np.inf]])
    return np.asarray(np.log(np.diff(2.0 / np.pi * np.arctan(borders / _USUAL))))


def _log_density(covariance: FloatArray, values: FloatArray) -> float:
    factor, lower = cho_factor(covariance, lower=True)
    volume = 2.0 * float(np.log(np.diag(factor)).sum())
    return -0.5 * (float(values @ cho_solve((factor, lower), values)) + volume)


def _by_pose(fit: Refit, kept: Sequence[Candidate], places: Sequence[Places]) -> list[FloatArray]:
    """Return what amplitudes that are other ones in each pose do to the patches of groups [m]."""
    found = []
    for group, place in zip(fit.groups, places, strict=True):
        own = np.zeros((len(place.along), len(kept), place.view_count))
        for number, candidate in enumerate(kept):
            own[:, number, place.view] = _moved(fit, group, candidate.names)
        found.append(own.reshape(len(own), -1))
    return found


def _of_form(
    fit: Refit, kept: Sequence[Candidate], places: Sequence[Places], *, with_picture: bool
) -> list[FloatArray]:
    """Return what effects in other forms do to the patches of each group, each by itself [m]."""
    return [
        np.hstack([_ways_of(fit, group, candidate, place, with_picture) for candidate in kept])
        for group, place in zip(fit.groups, places, strict=True)
    ]


def _ways_of(
    fit: Refit, group: PatchGroup, candidate: Candidate, place: Places, with_picture: bool
) -> FloatArray:
    effect = candidate.effect
    functions = place.functions(effect.group)
    found = [place.times(_moved(fit, group, candidate.names), functions)]
    across = tuple(map(effect.amplitude_name, effect.across_picture)) if with_picture else ()
    indices = [fit.parameters.names.index(name) for name in across if name in candidate.names]
    if indices:
        # What it moves across the picture may point elsewhere, too: a lens moves all outwards.
        size = float(np.linalg.norm(fit.coordinates[indices]))
        slopes = group.patches.jacobian[:, indices]
        found += [place.times(size * slope, functions) for slope in slopes.T]
    return np.hstack(found)


def _moved(fit: Refit, group: PatchGroup, names: Sequence[str]) -> FloatArray:
    """Return how far amplitudes move the patches of a group, to first order [m], shape (n,)."""
    indices = [fit.parameters.names.index(name) for name in names]
    return np.asarray(group.patches.jacobian[:, indices] @ fit.coordinates[indices])
