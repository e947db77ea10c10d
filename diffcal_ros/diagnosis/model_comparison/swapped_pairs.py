# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pairs in which another effect is in the place of one that may only have stood in for it.

Alone a camera that may be elsewhere, whatever its lens, follows what a wrong bias of depth and a
clamp that gives way do together, better than either of the two. A second effect beside it is the
clamp then, and the camera stays, for pairs are looked for around the best single effects. With the
clamp known, and all parameters where that leaves them, the bias explains as much.

And alone two effects may explain about as much, of which beside a second one only one does: either
is fitted beside it, for tangents far from where a pair ends promise what they do not keep.
"""

from collections.abc import Sequence

from diffcal_ros.diagnosis.model_comparison.as_good_alone import as_good_alone
from diffcal_ros.diagnosis.model_comparison.hypothesis import AS_WELL, Hypothesis
from diffcal_ros.diagnosis.model_comparison.kept_of_pairs import freed_of, scores_beside
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import Judge, request_beside, with_more
from diffcal_ros.diagnosis.patch_fits.patch_fit import AT_FIRST
from diffcal_ros.diagnosis.screening.candidates import Candidate, identifiers_of
from diffcal_ros.diagnosis.screening.screening import Score, Screen
from diffcal_ros.diagnosis.screening.shortlist import distinct

# In the place of an effect is tried what explains so much of what that does, in log evidence, the
# best of them alone.
_AS_MUCH, _MOST = 0.8, 1


def with_swapped(
    pool: RefitPool,
    pairs: Sequence[Hypothesis],
    singles: Sequence[Hypothesis],
    scores: Screen,
    judge: Judge | None,
) -> list[Hypothesis]:
    """Return pairs with others that keep one effect of the best one, best first.

    Args:
        pool: who refit, and what the nominal model is.
        pairs: best first.
        singles: models with one effect each, best first.
        scores: of all candidates at the nominal fit.
        judge: see `finished`.
    """
    if not pairs or not pool.nominal.is_measured:
        return list(pairs)
    best, known = pairs[0], {pair.identifiers for pair in pairs}
    listed = [score.candidate for score in scores.scores]
    requests = list[RefitRequest]()
    for kept in best.added:
        (dropped,) = (own for own in best.added if own is not kept)
        requests += [
            _request(best, kept, score, singles)
            for score in _in_its_place(pool, best, kept, dropped, listed, singles)
            if identifiers_of((kept, score.candidate)) not in known
        ]
    return with_more(pool, pairs, requests, singles, judge)


def _in_its_place(
    pool: RefitPool,
    best: Hypothesis,
    kept: Candidate,
    dropped: Candidate,
    listed: Sequence[Candidate],
    singles: Sequence[Hypothesis],
) -> list[Score]:
    """Return what explains about as much beside one effect of a pair as the other one does.

    Or did so alone, where that other one was the best.
    """
    others = [own for own in listed if own.identifier != kept.identifier]
    found = distinct(scores_beside(pool.nominal, pool.base, best, kept, others))
    least = next((s for s in found if s.candidate.identifier == dropped.identifier), None)
    found = [score for score in found if score is not least]
    promising = list[Score]()
    if least is not None and least.log_evidence > 0.0:
        enough = _AS_MUCH * least.log_evidence
        promising = [score for score in found if score.log_evidence > enough][:_MOST]
    alone = _as_good_as(dropped, singles)
    more = [score for score in found if score.candidate.identifier in alone]
    return [*promising, *(score for score in more if score not in promising)]


def _as_good_as(dropped: Candidate, singles: Sequence[Hypothesis]) -> set[str]:
    """Return what explained about as much alone as an effect that explained most."""
    if not singles or singles[0].identifiers != (dropped.identifier,):
        return set()
    scale = max(1.0, singles[0].chi_square_per_patch)
    return as_good_alone(singles, AS_WELL * scale) - {dropped.identifier}


def _request(
    best: Hypothesis, kept: Candidate, score: Score, singles: Sequence[Hypothesis]
) -> RefitRequest:
    """Return the refit of one effect of a pair and what is in the place of the other one."""
    stands, both = best.fit.values_by_name(), [kept, score.candidate]
    # Without what is taken out that is where no fit ended.
    return request_beside(stands, both, score, singles, freed_of(best, kept), AT_FIRST)
