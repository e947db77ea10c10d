# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pairs with what may be another one in each pose in the place of what has to be, and hardly is.

A weight that slides along a body as that is turned pulls from another place in each pose. Beside a
reading tangents of one weight at one place see next to nothing of it, and a tilt that is another
one in each pose follows it. Where the best pair asks for that of a load, a shape or a material,
what moves by its nature is looked for in its place, as another one in each pose from the start.
"""

from collections.abc import Sequence

from diffcal_ros.diagnosis.model_comparison.hypothesis import FARTHEST_FORM, Hypothesis
from diffcal_ros.diagnosis.model_comparison.kept_of_pairs import freed_of, scores_beside
from diffcal_ros.diagnosis.model_comparison.looks_in_any_form import in_each_pose
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import by_evidence, finished, Judge
from diffcal_ros.diagnosis.patch_fits.patch_fit import AT_FIRST
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Score, Screen
from diffcal_ros.diagnosis.screening.shortlist import distinct

# So many are tried in the place of one, those that tangents in each pose lead farthest, for so
# many evaluations at first.
_MOST, _EVALUATIONS = 4, 6


def with_what_moves(
    pool: RefitPool,
    pairs: Sequence[Hypothesis],
    singles: Sequence[Hypothesis],
    scores: Screen,
    judge: Judge | None,
) -> list[Hypothesis]:
    """Return pairs with others that keep one effect of the best one, best first.

    Args:
        pool: who refit, and what the nominal model is.
        pairs: judged, best first.
        singles: models with one effect each.
        scores: of all candidates at the nominal fit.
        judge: see `finished`.
    """
    if judge is None or not pairs:
        return list(pairs)
    best, listed = pairs[0], [score.candidate for score in scores.scores]
    if best.judged is None or best.judged.by_pose <= FARTHEST_FORM:
        return list(pairs)
    requests = [
        _request(pool, best, kept, score.candidate)
        for kept, dropped in (best.added, best.added[::-1])
        if dropped.effect.most_by_pose < 1.0
        for score in _in_its_place(pool, best, kept, listed)
    ]
    rivals = [*singles, *pairs]
    more = finished(pool, pool.refit_all(requests), rivals=rivals, judge=judge)
    return sorted([*pairs, *(judge(more) if more else [])], key=by_evidence)


def _in_its_place(
    pool: RefitPool, best: Hypothesis, kept: Candidate, listed: Sequence[Candidate]
) -> list[Score]:
    """Return what explains most in each pose beside one effect of a pair, one score an effect."""
    moving = [
        own
        for own in listed
        if own.effect.most_by_pose >= 1.0
        and own.effect.has_tangent
        and own.identifier not in best.identifiers
    ]
    found = scores_beside(pool.nominal, pool.base, best, kept, moving)
    explaining = [score for score in found if score.gain_by_pose > 0.0]
    return distinct(sorted(explaining, key=lambda score: -score.gain_by_pose))[:_MOST]


def _request(pool: RefitPool, best: Hypothesis, kept: Candidate, added: Candidate) -> RefitRequest:
    """Return the refit of one effect of a pair and of what is another one in each pose.

    What is never negative begins at its usual size: from its bound at zero it may not get away.
    """
    begun = {
        name: part.scale
        for name, part in zip(added.names, added.parts, strict=True)
        if part.lower == 0.0
    }
    starts = {**best.fit.values_by_name(), **begun, **added.screened}
    freed = (*freed_of(best, kept), *in_each_pose(pool, added))
    return RefitRequest((kept, added), starts, _EVALUATIONS, freed=freed, pace=AT_FIRST)
