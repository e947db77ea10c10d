# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models that may be better in a form of their own, which to first order says nothing of that."""

from collections.abc import Sequence

from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_sizes import refitted
from diffcal_ros.diagnosis.model_comparison.freedom import (
    freed_parts,
    freeing_request,
    LEAST_SHARE,
    with_refits,
)
from diffcal_ros.diagnosis.model_comparison.hypothesis import (
    AS_WELL,
    Hypothesis,
    LEAST_LEANING,
    USUAL_FORM,
)
from diffcal_ros.diagnosis.model_comparison.judged_models import judged
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_rounds import (
    best_of_each,
    by_evidence,
    least_level,
)

# By so much of what it owes to forms a model may be better once they are fitted: mostly by 0.1 to
# 0.3, and by 1.6 where the first step was far off.
_LED_ON = 0.4
# Rivals that are freed, one after the other overtaking the best.
_OVERTAKEN = 2


def with_its_rival_freed(
    pool: RefitPool, models: Sequence[Hypothesis], basis: FormBasis
) -> list[Hypothesis]:
    """Return models, the nearest rival of the best one free in form, where that may decide.

    To first order it may owe next to nothing to forms, and be far better in one: where a body is
    eight times stiffer at one end than at the other nothing is linear. So it is free where the
    best one is, and where a form that is fitted may bring it near: a body that was propped up is
    bent along its inner half, and a clamp that is turned comes near in the library's form. What it
    overtakes so is free as well.

    Args:
        pool: see `freed_effects.with_those_freed`.
        models: judged, best first.
        basis: see `freed_effects.with_those_freed`.
    """
    for _ in range(_OVERTAKEN):
        before, models = models, _with_a_rival_freed(pool, models, basis)
        if models[0] is before[0]:
            break
    return list(models)


def _with_a_rival_freed(
    pool: RefitPool, models: Sequence[Hypothesis], basis: FormBasis
) -> list[Hypothesis]:
    """Return models, the nearest rival of the best one free in form, best first."""
    first, *others = models
    for place, rival in enumerate(others):
        if rival.is_at_bound or rival.identifiers == first.identifiers:
            continue
        if not _may_come_near(rival, first):
            continue
        # One that is free already and at its best is as it would be.
        if freed_parts(rival, LEAST_SHARE) or (rival.freed and not rival.fit.is_converged):
            both = with_refits(pool, rival, [freeing_request(rival, LEAST_SHARE)], basis)
            others[place] = min(both, key=by_evidence)
            return sorted([first, *others], key=by_evidence)
    return list(models)


def _may_come_near(rival: Hypothesis, first: Hypothesis) -> bool:
    """Tell whether a model free in form may explain about as much as the best one.

    By what forms owed it to first order is better once they are fitted, or by leaving noise alone.
    """
    judged = rival.judged
    if judged is None:
        return False
    if first.freed and rival.level > least_level(first):
        return True
    if _is_in_doubt(first) and rival.leaning > LEAST_LEANING:
        return True
    left = max(judged.chi_square - judged.freedom, 0.0)
    led_on = rival.level + _LED_ON * max(rival.leaning, 0.0)
    at_most = max(led_on, rival.log_evidence + 0.5 * left)
    return at_most > first.level - AS_WELL * max(1.0, first.chi_square_per_patch)


def _is_in_doubt(model: Hypothesis) -> bool:
    """Tell whether data want a model in another form, so that it says little against others."""
    return model.judged is not None and model.judged.fraction > USUAL_FORM


def with_halves_freed(
    pool: RefitPool,
    singles: Sequence[Hypothesis],
    pairs: Sequence[Hypothesis],
    basis: FormBasis | None,
) -> list[Hypothesis]:
    """Return single effects, those of the best pair free in form where that pair leads.

    Two effects of the library's form can be one of another form: a body that is softer at two
    folds sags like one that is heavier and softer at its end. To first order its form may say
    nothing of that.

    Args:
        pool: see `freed_effects.with_those_freed`.
        singles: models with one effect each, judged, best first.
        pairs: with two, judged.
        basis: see `freed_effects.with_those_freed`.
    """
    if basis is None or not (singles and pairs):
        return list(singles)
    best = min(pairs, key=by_evidence)
    if best.level <= singles[0].level:
        return list(singles)
    requests = [
        freeing_request(single, LEAST_SHARE)
        for single in best_of_each(singles)
        if single.identifiers[0] in best.identifiers
        and not (single.is_at_bound or single.is_free_in_form)
        and freed_parts(single, LEAST_SHARE)
    ]
    if not requests:
        return list(singles)
    found = judged(refitted(pool, requests), basis, is_brief=True)
    return sorted([*singles, *found], key=by_evidence)
