# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Second effects beside the best single ones: which are tried, and what they come to."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.model_comparison.effect_refit import with_fewer_effects
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_fits import each_alone
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
from diffcal_ros.diagnosis.model_comparison.guessed_floor import ranked
from diffcal_ros.diagnosis.model_comparison.hypothesis import FORM_DOUBT, Hypothesis
from diffcal_ros.diagnosis.model_comparison.judged_models import judge_by, judged
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import (
    best_of_each,
    by_evidence,
    finished,
    first_request,
    request_beside,
    within_reach,
)
from diffcal_ros.diagnosis.model_comparison.second_effect import most_gain, PAIR_GAIN
from diffcal_ros.diagnosis.patches.patch_group import Rows, rows_of
from diffcal_ros.diagnosis.screening.candidates import Candidate, identifiers_of
from diffcal_ros.diagnosis.screening.screening import Score, Screen, screen
from diffcal_ros.diagnosis.screening.shortlist import distinct, other_kinds
from diffcal_ros.errors import NotSimulatedError
import numpy as np

# Best single effects that a second one is sought for, and how many for each.
_FIRSTS, _SECONDS = 2, 3
# Pairs that are tried at most; fewer where the floor is a guess, and every fit a robust one.
_MOST_PAIRS, _MOST_PAIRS_GUESSED = 6, 4
# Of what tangents promise, and what stands in for them, a pair comes to so much at most; and how
# near it must come to one that leaves noise.
_TANGENTS_MISS, _STAND_INS_MISS, _FAR_TANGENTS_MISS = 1.25, 2.5, 4.0
_NEAR = 10.0
# Log evidence, per unit of noise scale, by which half of a pair must be better than it was alone.
_FARTHER = 2.0


def best_pairs(
    pool: RefitPool, singles: Sequence[Hypothesis], scores: Screen, basis: FormBasis | None
) -> list[Hypothesis]:
    """Add a second effect to the best single ones, by the scores around each.

    What the form of a single one may explain no second one needs to. Only what may add enough is
    tried, by tangents and what those miss, where these are known. What promises most comes first:
    where that leaves noise, others need not be tried whose tangents lead nowhere near; unless it
    owes that to forms other than the library's, which follow much that they are not.

    Args:
        pool: who refit, and what the nominal model is.
        singles: models with one effect each, best first.
        scores: of all candidates at the nominal fit.
        basis: by which forms are told; None: models are judged as they are.
    """
    most = _MOST_PAIRS if pool.nominal.is_measured else _MOST_PAIRS_GUESSED
    judge = judge_by(basis)
    least = max(h.level for h in singles) + PAIR_GAIN
    listed = _offers(pool, singles, scores, basis)
    hopeful = [offer for offer in listed if offer.at_most > least or not offer.is_known]
    untold = [offer for offer in hopeful[most:] if offer.is_untold]
    offers = [*hopeful[:most], *untold]
    if not pool.nominal.is_measured or len(offers) < 2:
        pairs = pool.refit_all([offer.request for offer in offers])
        return finished(pool, pairs, rivals=singles, judge=judge)
    first = max(offers, key=lambda offer: offer.expected)
    found = finished(pool, pool.refit_all([first.request]), rivals=singles, judge=judge)
    rivals, rest = [*singles, *found], [offer for offer in offers if offer is not first]
    if found:
        (best,) = judged(found, basis, is_brief=True)
        scale = max(1.0, best.chi_square_per_patch)
        if most_gain(best) <= PAIR_GAIN * scale and _owes_little(best):
            near = best.level - _NEAR * scale
            # Of a plane and a bar tangents do not tell which one it is.
            rest = [own for own in rest if own.at_most > near or own.names == best.identifiers]
    more = [replace(o.request, least_log_evidence=within_reach(rivals)) for o in rest]
    others = finished(pool, pool.refit_all(more), rivals=rivals, judge=judge)
    return sorted([*found, *others], key=by_evidence)


@dataclass(frozen=True)
class _Offer:
    """A pair that may be refitted.

    Attributes:
        request: to refit it.
        start: level of the single effect that it adds to.
        gain: what tangents there promise of it.
        misses: how many times that it comes to at most.
        is_known: whether tangents tell that.
    """

    request: RefitRequest
    start: float
    gain: float
    misses: float
    is_known: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Identifiers of its effects, in their order."""
        return identifiers_of(self.request.added)

    @property
    def expected(self) -> float:
        """Level where the promise is kept."""
        return self.start + self.gain

    @property
    def at_most(self) -> float:
        """Level where as much more than that is kept as may be."""
        return self.start + self.misses * self.gain

    @property
    def is_untold(self) -> bool:
        """Whether no tangents tell what it comes to."""
        return bool(np.isinf(self.misses))


def _offers(
    pool: RefitPool, singles: Sequence[Hypothesis], scores: Screen, basis: FormBasis | None
) -> list[_Offer]:
    """Return the pairs of the best single effects with what scores best around each."""
    found: dict[tuple[str, ...], _Offer] = {}
    listed = [score.candidate for score in scores.scores]
    best = singles[0]
    is_enough = best.leaves_noise and _owes_little(best)
    for one in best_of_each(singles)[:_FIRSTS]:
        (first,) = one.added
        others = [c for c in listed if c.identifier != first.identifier]
        # Beside noise tangents tell what a second effect may add. Beside more they begin far from
        # where both put the body: of a bend that leaves millimetres a plane was to add 11 in log
        # evidence, and adds 190. Where another one leaves noise alone it is not looked for so.
        is_known = pool.nominal.is_measured and (one.leaves_noise or is_enough)
        try:
            again = screen(one.evaluator, one.fit.coordinates, others, _forms(one, basis))
        except NotSimulatedError:
            continue  # No steps lead there again, see `lead_to`.
        tells = is_known or one is not best
        for score in _seconds(
            first, again.scores, is_measured=pool.nominal.is_measured, tells=tells
        ):
            names = identifiers_of((first, score.candidate))
            # Of a plane and a bar tangents know nothing: both are tried.
            is_one = pool.nominal.is_measured and score.candidate.effect.has_tangent
            key = names if is_one else (*names, *score.candidate.components)
            stands, both = one.fit.values_by_name(), [first, score.candidate]
            request = request_beside(stands, both, score, singles, one.freed)
            misses = _misses(one, request.added, tells=tells)
            offer = _Offer(request, one.level, score.log_evidence, misses, is_known)
            found.setdefault(key, offer)
    return list(found.values())


def _owes_little(model: Hypothesis) -> bool:
    """Tell whether what a model owes to other forms than the library's decides nothing."""
    return FORM_DOUBT * model.leaning <= PAIR_GAIN * max(1.0, model.chi_square_per_patch)


def _seconds(
    first: Candidate, scores: Sequence[Score], *, is_measured: bool, tells: bool
) -> list[Score]:
    """Return what is offered beside a first effect, each in its best variant.

    What another material does, it does from one border on: by a guessed floor nothing rules such a
    variant out. Beside what leaves more than noise what stands in for contact tells nothing: of a
    body that a step of depth was to explain, and that was eight times too stiff for it, a plane
    was to explain 25 and explains 254.

    Args:
        first: the first effect.
        scores: around it, best first.
        is_measured: whether the sensor floor was.
        tells: whether scores tell of what has no tangent how much it may add.
    """
    every = distinct(scores)
    best = every[:_SECONDS]
    if not tells:
        best += [own for own in every[_SECONDS:] if _has_no_tangent(own) and own.gain > 0.0]
    if is_measured:
        by_name = (
            [other for other in scores if other.candidate.identifier == own.candidate.identifier]
            for own in best
        )
        return [*best, *(own for listed in by_name for own in other_kinds(listed, listed[:1]))]
    if not first.effect.has_boundary:
        return best
    chosen = {own.candidate for own in best}
    likewise = {own.identifier for own in chosen if own.effect.has_boundary}
    return [s for s in scores if s.candidate in chosen or s.candidate.identifier in likewise]


def _has_no_tangent(score: Score) -> bool:
    return not score.candidate.effect.has_tangent


def _misses(one: Hypothesis, added: Sequence[Candidate], *, tells: bool) -> float:
    """Return to how many times what tangents promise around a single effect a pair may come.

    Where that leaves much in any form, they begin far from where the pair is.

    Args:
        one: the single effect.
        added: both of the pair.
        tells: see `_seconds`.
    """
    is_smooth = all(candidate.effect.has_tangent for candidate in added)
    if not (is_smooth or tells):
        return np.inf
    if one.judged is not None and not one.leaves_noise:
        return _FAR_TANGENTS_MISS
    return _TANGENTS_MISS if is_smooth else _STAND_INS_MISS


def _forms(one: Hypothesis, basis: FormBasis | None) -> Rows | None:
    """Return what the form of a single effect may do to the patches of its fit."""
    if basis is None or one.judged is None:
        return None
    ways = ways_of(one.evaluator.model, one.fit, basis, one.added)
    return rows_of(one.fit.groups, ways.scaled(one.judged.by_pose, one.judged.fraction))


def halves(
    pool: RefitPool,
    singles: Sequence[Hypothesis],
    pairs: Sequence[Hypothesis],
    basis: FormBasis | None,
) -> list[Hypothesis]:
    """Fit each effect of the best pair without the other, from where the pair ended.

    From the nominal fit a large effect may not be reached, and be found as a part of a pair only.
    Where tangents lead no farther from the pair than the effect has come alone, it is not tried.

    Args:
        pool: who refit, and what the nominal model is.
        singles: models with one effect each, best first.
        pairs: with two.
        basis: see `best_pairs`.
    """
    if not pairs:
        return []
    if pool.nominal.stays_robust:
        return _halves_by_most_patches(pool, singles, pairs)
    best = min(judged(pairs, basis, is_brief=True), key=by_evidence)
    if best.level < singles[0].level:
        return []
    # Judged with a tolerance for forms one that was given up has come as far.
    ended = [single for single in singles if single.fit.is_converged or basis is not None]
    alone = {single.added[0].identifier: single.level for single in best_of_each(ended)}
    least = {
        own.identifier: alone.get(own.identifier, -np.inf)
        + _FARTHER * max(1.0, best.chi_square_per_patch)
        for own in best.added
    }
    if basis is not None:
        led = judged(each_alone(pool, best, basis), basis, is_brief=True)
        farther = [model for model in led if model.level > least[model.added[0].identifier]]
        return pool.finish(farther, [-np.inf] * len(farther))
    requests = [
        first_request([added], best.fit.values_by_name(), [best])
        for added in best.added
        if with_fewer_effects(pool.nominal, pool.base, best, [added]).fit.log_evidence
        > least[added.identifier]
    ]
    return finished(pool, pool.refit_all(requests), rivals=[best])


def _halves_by_most_patches(
    pool: RefitPool, singles: Sequence[Hypothesis], pairs: Sequence[Hypothesis]
) -> list[Hypothesis]:
    """Return the halves of the best pair where the floor is a guess.

    Robust fits end where they began: what a pair leaves less may be a better end alone.
    """
    levelled = ranked([*singles, *pairs])
    best = min(levelled[len(singles) :], key=by_evidence)
    if best.level < max(single.level for single in levelled[: len(singles)]):
        return []
    starts = best.fit.values_by_name()
    return pool.refit_all([first_request([added], starts) for added in best.added])
