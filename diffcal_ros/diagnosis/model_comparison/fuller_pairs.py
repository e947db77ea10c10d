# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The best pair with all amplitudes that its effects may have.

Beside a first effect tangents say which amplitudes of a second one pay, around a body that is not
yet where both put it. A camera that swings round the body was taken for one that is displaced
alone, and its turns hid in poses that are known to tenths of a degree.
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_rounds import first_request, Judge, with_more
from diffcal_ros.diagnosis.patch_fits.patch_fit import FROM_A_FIT
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Screen


def with_all_amplitudes(
    pool: RefitPool,
    pairs: Sequence[Hypothesis],
    singles: Sequence[Hypothesis],
    scores: Screen,
    judge: Judge | None,
) -> list[Hypothesis]:
    """Return pairs, and the best one with all amplitudes that its effects may have, best first.

    Args:
        pool: who refit, and what the nominal model is.
        pairs: best first.
        singles: models with one effect each, best first.
        scores: of all candidates at the nominal fit.
        judge: see `finished`.
    """
    if not pairs or not pool.nominal.is_measured:
        return list(pairs)
    best, listed = pairs[0], [score.candidate for score in scores.scores]
    whole = [_with_all(own, listed) for own in best.added]
    if all(one is own for one, own in zip(whole, best.added, strict=True)):
        return list(pairs)
    request = first_request(whole, best.fit.values_by_name(), [*singles, *pairs])
    request = replace(request, freed=best.freed, pace=FROM_A_FIT)
    return with_more(pool, pairs, [request], singles, judge)


def _with_all(own: Candidate, listed: Sequence[Candidate]) -> Candidate:
    """Return the candidate of the same effect and settings that has most besides what one has."""
    more = [other for other in listed if other.extends(own)]
    return max(more, key=lambda other: len(other.components), default=own)
