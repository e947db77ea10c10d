# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refit the best candidates with all nominal parameters, and compare what is left."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from diffcal_ros.diagnosis.detection.disagreement import ALPHA
from diffcal_ros.diagnosis.model_comparison.absence import has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, with_tolerance
from diffcal_ros.diagnosis.model_comparison.patch_fit import HOPE
from diffcal_ros.diagnosis.model_comparison.refit import Refit
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.second_effect import (
    Explained,
    most_added,
    second_adds,
)
from diffcal_ros.diagnosis.model_comparison.strain import unstrained
from diffcal_ros.diagnosis.patches.whitened import closed_fraction, Part, patch_gap, whiten
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Score, Screen, screen
from diffcal_ros.diagnosis.screening.shortlist import (
    distinct,
    front_runners,
    shortlist,
    starts_of,
    with_tangents,
)
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Evaluations of the model in a first request, and where one of the effects needs a long one; and
# how far behind in log evidence per unit of noise scale a model may then be to be fitted on.
_BRIEF, _LONG = 4, 8
# So many times a model that ran out of evaluations, and may still win, is fitted on.
_ROUNDS = 2
_OUT_OF_REACH = 40.0
# Models this close in log evidence, per unit of noise scale, explain the data as well.
AS_WELL = 5.0
# Where the floor is a guess, what most patches are off by in floors where something may be left.
_POOR_FLOORS = 2.0
# Best single effects that a second one is sought for, and how many for each.
_FIRSTS, _SECONDS = 2, 3
# Pairs that are tried at most; fewer where the floor is a guess, and every fit a robust one.
_MOST_PAIRS, _MOST_PAIRS_GUESSED = 6, 1
# Of what tangents promise, and what stands in for them, a pair comes to so much at most; and how
# near it must come to one that leaves noise.
_TANGENTS_MISS, _STAND_INS_MISS = 1.25, 2.5
_NEAR = 10.0
# A second effect must be better by so much log evidence, per unit of noise scale, and by so much
# log likelihood on held-out patches. Where the floor is a guess likelihoods are too: it must close
# so much of what the first one leaves on those.
_PAIR_GAIN, _HELD_OUT_GAIN = 8.0, 4.0
_CLOSES_GUESSED = 0.5


@dataclass(frozen=True)
class Selection:
    """Refitted models.

    Attributes:
        singles: one effect each, best first.
        pairs: two effects each, best first.
        noise_scale: chi-square per patch of the best of all, at least 1.
        is_measured: whether the sensor floor was.
        added: what the best pair adds to what one effect in any form explains; None: not known.
    """

    singles: tuple[Hypothesis, ...]
    pairs: tuple[Hypothesis, ...] = field(default_factory=tuple)
    noise_scale: float = 1.0
    is_measured: bool = True
    added: Explained | None = None

    @property
    def best(self) -> Hypothesis | None:
        """The model that the data favour: two effects only where one is not enough."""
        if not self.singles:
            return None
        two = self._needed_pair()
        if two is None or self.rival is not None:
            return self._fullest(self.singles[0])
        return two

    @property
    def rival(self) -> Hypothesis | None:
        """Two effects that explain more than the best one, which is none of them and may be it.

        What the one leaves in about its own form is noise: nothing says that there are two.
        """
        two = self._needed_pair()
        if two is None or not self.is_measured:
            return None
        one = self.singles[0]
        is_part = set(one.identifiers) <= set(two.identifiers)
        return None if is_part or one.chance_of_noise < ALPHA else two

    def _needed_pair(self) -> Hypothesis | None:
        """Return the best pair where one effect is not enough, in whatever form."""
        if not (self.singles and self.pairs):
            return None
        one, two = self._fullest(self.singles[0]), self.pairs[0]
        gains = [two.log_evidence - one.log_evidence]
        transfer = np.inf
        if self.added is not None:
            gains.append(self.added.log_evidence)
            transfer = self.added.log_transfer
        is_more = min(gains) > _PAIR_GAIN * self.noise_scale
        is_everywhere = transfer > _HELD_OUT_GAIN * self.noise_scale
        return two if is_more and is_everywhere and self._is_confirmed(one, two) else None

    def _is_confirmed(self, one: Hypothesis, two: Hypothesis) -> bool:
        """Tell whether held-out patches want the second effect, too."""
        if not self.is_measured:
            return _closed(one.fit, two.fit) > _CLOSES_GUESSED
        if one.judged is not None and two.judged is not None:
            told = two.judged.log_prediction - one.judged.log_prediction
            return told / self.noise_scale > _HELD_OUT_GAIN
        fits = (one.fit, two.fit)
        likelihoods = [-0.5 * whiten(fit.groups, Part.REPORT).chi_square for fit in fits]
        return (likelihoods[1] - likelihoods[0]) / self.noise_scale > _HELD_OUT_GAIN

    def _fullest(self, leader: Hypothesis) -> Hypothesis:
        """Return the variant of an effect with most amplitudes that explains the data as well.

        One that leaves an amplitude out is sure of what it cannot know.
        """
        least = leader.log_evidence - AS_WELL * self.noise_scale
        variants = [
            h
            for h in self.singles
            if h.identifiers == leader.identifiers
            and h.log_evidence > least
            and not (h.is_at_bound or h.has_absent_amplitude)
        ]
        return max(variants, key=_amplitude_count, default=leader)


def _closed(one: Refit, two: Refit) -> float:
    """Return the share of the excess on held-out patches that a second effect closes."""
    before, after = patch_gap(one.groups, Part.REPORT), patch_gap(two.groups, Part.REPORT)
    floor = before.whole_floor
    if before.most - floor <= 0.2 * floor:
        return 0.0
    return closed_fraction(before.most, after.most, floor)


def select(pool: RefitPool, scores: Screen) -> Selection:
    """Refit candidates, and pairs where no single one is enough.

    Args:
        pool: who refit, and what the nominal model is.
        scores: of all candidates.
    """
    is_measured = pool.nominal.is_measured
    singles = _singles(pool, scores)
    if singles and all(h.has_idle_effect for h in singles):
        # What stood in for those without a tangent kept others out, and they do nothing.
        singles = _singles(pool, with_tangents(scores))
    singles = _judged(pool, singles)
    pairs: list[Hypothesis] = []
    if singles and _is_poor(pool, singles[0]):
        pairs = _pairs(pool, singles, scores)
        singles = sorted([*singles, *_halves(pool, singles, pairs)], key=_order)
    singles = _judged(pool, [h for h in singles if not h.has_idle_effect])
    pairs = [
        h for h in pairs if not (h.has_idle_effect or has_doubtful_effect(h, pool.base, singles))
    ]
    pairs = _judged(pool, pairs)
    best = min([*singles, *pairs], key=lambda h: h.chi_square_per_patch, default=None)
    scale = 1.0 if best is None else max(1.0, best.chi_square_per_patch)
    added = None
    if singles and pairs and pairs[0].judged is not None:
        added = second_adds(singles[0], pairs[0], _nominal_points(pool))
    return Selection(tuple(singles), tuple(pairs), scale, is_measured, added)


def _singles(pool: RefitPool, scores: Screen) -> list[Hypothesis]:
    """Refit the effects that their scores speak for, one at a time; best first."""
    listed = shortlist(scores, is_measured=pool.nominal.is_measured)
    refits = pool.refit_all(
        [_first_request([score.candidate], starts_of(score)) for score in listed]
    )
    return _finished(pool, refits, front_runners(scores))


def _first_request(
    added: Sequence[Candidate], starts: dict[str, float], rivals: Sequence[Hypothesis] = ()
) -> RefitRequest:
    """Return a brief refit, given up where it will hardly come near its rivals."""
    most = _LONG if any(candidate.effect.needs_long_look for candidate in added) else _BRIEF
    return RefitRequest(tuple(added), starts, most, _within_reach(rivals))


def _within_reach(rivals: Sequence[Hypothesis]) -> float:
    """Return the log evidence below which a model is out of reach of the best of others."""
    if not rivals:
        return -np.inf
    scale = max(1.0, min(h.fit.chi_square_per_patch for h in rivals))
    return max(h.fit.log_evidence for h in rivals) - _OUT_OF_REACH * scale


def _is_poor(pool: RefitPool, hypothesis: Hypothesis) -> bool:
    """Tell whether one effect leaves so much that a second one is sought."""
    if pool.nominal.is_measured:
        least = _PAIR_GAIN * max(1.0, hypothesis.chi_square_per_patch)
        if most_gain(hypothesis) <= least:
            return False
        in_form = hypothesis.judged is None
        return in_form or most_added(hypothesis, _nominal_points(pool)) > least
    left = patch_gap(hypothesis.fit.groups, Part.FIT)
    return left.most > _POOR_FLOORS * left.whole_floor


def most_gain(hypothesis: Hypothesis) -> float:
    """Return how much log evidence a further effect could gain that costs nothing.

    It would leave noise alone, pull no parameter from where it is likely, and need no tolerance
    for the form of the effects that are there, which has gained some of that before.
    """
    fit = hypothesis.fit
    noise = fit.patch_count - len(fit.coordinates)
    left = fit.chi_square - noise + fit.prior_chi_square
    return 0.5 * left - (hypothesis.log_evidence - fit.log_evidence)


def _finished(
    pool: RefitPool,
    brief: Sequence[Hypothesis],
    front: frozenset[str] = frozenset(),
    rivals: Sequence[Hypothesis] = (),
) -> list[Hypothesis]:
    """Fit the models that may still win, or lead by their scores, to the end; best first."""
    models = list(brief)
    for _ in range(_ROUNDS):
        reach = _within_reach([*models, *rivals])
        worth: dict[int, float] = {}
        for index, hypothesis in enumerate(models):
            fit = hypothesis.fit
            least = -np.inf if front & set(hypothesis.identifiers) else reach
            # After a brief look a model may be far behind, and halfway down.
            if not fit.is_converged and fit.log_evidence + HOPE * fit.promise >= least:
                worth[index] = least
        further = pool.finish([models[index] for index in worth], list(worth.values()))
        for index, hypothesis in zip(worth, further, strict=True):
            models[index] = hypothesis
        # A twin that ran out of evaluations is no reason to be sure of the other one.
        front = frozenset()
    return sorted(models, key=_order)


def _judged(pool: RefitPool, models: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Judge models with a tolerance for the form of their effects; best first."""
    base = replace(pool.base, groups=unstrained(pool.base))
    points = _nominal_points(pool)
    return sorted((with_tolerance(h, base, points) for h in models), key=_order)


def _nominal_points(pool: RefitPool) -> list[FloatArray]:
    """Return the nodes of the nominal body in each view [m], camera frame, shape (N, 3) each."""
    return [view.points for view in pool.nominal.model.views(pool.base.coordinates)]


def _order(hypothesis: Hypothesis) -> tuple[bool, float]:
    return hypothesis.is_at_bound, -hypothesis.log_evidence


def _amplitude_count(hypothesis: Hypothesis) -> int:
    return sum(len(candidate.components) for candidate in hypothesis.added)


def _pairs(pool: RefitPool, singles: Sequence[Hypothesis], scores: Screen) -> list[Hypothesis]:
    """Add a second effect to the best single ones, by the scores around each.

    What promises most comes first: where that leaves noise, others need not be tried whose
    tangents lead nowhere near.
    """
    most = _MOST_PAIRS if pool.nominal.is_measured else _MOST_PAIRS_GUESSED
    offers = _offers(pool, singles, scores)[:most]
    if not pool.nominal.is_measured or len(offers) < 2:
        return _finished(pool, pool.refit_all([offer.request for offer in offers]), rivals=singles)
    first = max(offers, key=lambda offer: offer.expected)
    found = _finished(pool, pool.refit_all([first.request]), rivals=singles)
    rivals, rest = [*singles, *found], [offer for offer in offers if offer is not first]
    scale = max(1.0, found[0].chi_square_per_patch) if found else 1.0
    if found and most_gain(found[0]) <= _PAIR_GAIN * scale:
        least = found[0].fit.log_evidence - _NEAR * scale
        rest = [offer for offer in rest if offer.at_most > least]
    more = [replace(o.request, least_log_evidence=_within_reach(rivals)) for o in rest]
    others = _finished(pool, pool.refit_all(more), rivals=rivals)
    return sorted([*found, *others], key=_order)


@dataclass(frozen=True)
class _Offer:
    """A pair that may be refitted.

    Attributes:
        request: to refit it.
        start: log evidence of the single effect that it adds to.
        gain: what tangents there promise of it.
    """

    request: RefitRequest
    start: float
    gain: float

    @property
    def expected(self) -> float:
        """Log evidence where the promise is kept."""
        return self.start + self.gain

    @property
    def at_most(self) -> float:
        """Log evidence where more than that is kept."""
        is_smooth = all(candidate.effect.has_tangent for candidate in self.request.added)
        return self.start + (_TANGENTS_MISS if is_smooth else _STAND_INS_MISS) * self.gain


def _offers(pool: RefitPool, singles: Sequence[Hypothesis], scores: Screen) -> list[_Offer]:
    """Return the pairs of the best single effects with what scores best around each."""
    found: dict[tuple[str, ...], _Offer] = {}
    listed = [score.candidate for score in scores.scores]
    for one in _distinct(singles)[:_FIRSTS]:
        (first,) = one.added
        others = [c for c in listed if c.identifier != first.identifier]
        try:
            again = screen(one.evaluator, one.fit.coordinates, others)
        except NotSimulatedError:
            continue  # It was reached by small load steps, and is not found from rest.
        tried = distinct(again.scores)[:_SECONDS]
        if pool.nominal.is_measured:
            tried = _worth_adding(one, tried, singles)
        for score in tried:
            key = tuple(sorted((first.identifier, score.candidate.identifier)))
            starts = {**_fitted(one), **starts_of(score)}
            request = _first_request([first, score.candidate], starts, singles)
            found.setdefault(key, _Offer(request, one.fit.log_evidence, score.log_evidence))
    return list(found.values())


def _worth_adding(
    one: Hypothesis, scores: Sequence[Score], singles: Sequence[Hypothesis]
) -> list[Score]:
    """Return the second effects that may add enough, by their tangents where the first one ended.

    With several times what these promise a pair must exceed each single effect by what is asked.
    """
    least = max(h.fit.log_evidence for h in singles) + _PAIR_GAIN
    return [
        score
        for score in scores
        # What has no tangent at zero is not told by what stands in for it.
        if not score.candidate.effect.has_tangent
        or one.fit.log_evidence + HOPE * score.log_evidence > least
    ]


def _halves(
    pool: RefitPool, singles: Sequence[Hypothesis], pairs: Sequence[Hypothesis]
) -> list[Hypothesis]:
    """Refit each effect of the best pair without the other, from where the pair ended.

    From the nominal fit a large effect may not be reached, and be found as a part of a pair only.
    """
    if not pairs or pairs[0].fit.log_evidence < singles[0].fit.log_evidence:
        return []
    best = pairs[:1]
    requests = [_first_request([added], _fitted(best[0]), best) for added in best[0].added]
    return _finished(pool, pool.refit_all(requests), rivals=best)


def _fitted(hypothesis: Hypothesis) -> dict[str, float]:
    fit = hypothesis.fit
    return dict(zip(fit.parameters.names, fit.coordinates.tolist(), strict=True))


def _distinct(singles: Sequence[Hypothesis]) -> list[Hypothesis]:
    first: dict[str, Hypothesis] = {}
    for hypothesis in singles:
        first.setdefault(hypothesis.added[0].identifier, hypothesis)
    return list(first.values())
