# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models with one effect each: which are refitted, in which order, and which need not be."""

from collections.abc import Sequence

from diffcal_ros.diagnosis.model_comparison.effect_refit import with_fewer_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import (
    by_evidence,
    finished,
    first_request,
    Judge,
)
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Score, Screen
from diffcal_ros.diagnosis.screening.shortlist import front_runners, shortlist, starts_of

# A model without some of an effect's amplitudes is refitted where tangents lead within so much log
# evidence of that with all, per unit of noise scale; farther off it is what they say.
_NEAR = 10.0


def refitted_singles(
    pool: RefitPool, scores: Screen, judge: Judge | None = None, *, looks_long: bool = True
) -> list[Hypothesis]:
    """Refit the effects that their scores speak for, one at a time; best first.

    Args:
        pool: who refit, and what the nominal model is.
        scores: of all candidates.
        judge: see `finished`.
        looks_long: whether effects that take long are among them beside others that do not.
    """
    listed = shortlist(scores, is_measured=pool.nominal.is_measured)
    if not looks_long:
        listed = [s for s in listed if not s.candidate.effect.needs_long_look] or listed
    whole = [score for score in listed if _fuller(score, listed) is None]
    parts = [score.candidate for score in listed if _fuller(score, listed) is not None]
    quick = [score for score in whole if not score.candidate.effect.needs_long_look]
    # What takes long is looked at when it is known what it must come near.
    late = [score for score in whole if score.candidate.effect.needs_long_look]
    brief = pool.refit_all([_request(score) for score in quick])
    front = front_runners(scores)
    found = finished(pool, brief, front, late=[_request(score) for score in late], judge=judge)
    return sorted([*found, *_parts(pool, parts, found, judge)], key=by_evidence)


def _request(score: Score) -> RefitRequest:
    return first_request([score.candidate], starts_of(score))


def _fuller(score: Score, listed: Sequence[Score]) -> Score | None:
    """Return the variant of the same effect that has all its amplitudes and more, if any has."""
    own = score.candidate
    fuller = [other for other in listed if other.candidate.extends(own)]
    return max(fuller, key=lambda other: len(other.candidate.components), default=None)


def _parts(
    pool: RefitPool,
    parts: Sequence[Candidate],
    found: Sequence[Hypothesis],
    judge: Judge | None,
) -> list[Hypothesis]:
    """Return the variants with fewer amplitudes, refitted where they may be the better ones."""
    near, far = [], []
    for part in parts:
        whole = next((h for h in found if h.added[0].extends(part)), None)
        if whole is None:  # It could not be simulated.
            near.append(first_request([part], {}, found))
            continue
        fewer = with_fewer_effects(pool.nominal, pool.base, whole, [part])
        if _may_be_better(fewer, whole, judge):
            near.append(first_request([part], fewer.fit.values_by_name(), found))
        else:
            far.append(fewer)
    return [*finished(pool, pool.refit_all(near), rivals=found, judge=judge), *far]


def _may_be_better(fewer: Hypothesis, whole: Hypothesis, judge: Judge | None) -> bool:
    """Tell whether a variant with fewer amplitudes may be the one that is kept.

    Of two that do as well in whatever form, the fullest one is (`Selection.best`).
    """
    if judge is not None and not whole.is_at_bound:
        one, other = judge([fewer, whole])
        return one.level > other.level
    scale = max(1.0, whole.fit.chi_square_per_patch)
    return fewer.log_evidence > whole.log_evidence - _NEAR * scale
