# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models whose effects are free in more ways than data ask for, fitted with fewer."""

from collections.abc import Sequence

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.freedom import MOST_EVALUATIONS, with_refits
from diffcal_ros.diagnosis.model_comparison.hypothesis import AS_WELL, FORM_DOUBT, Hypothesis
from diffcal_ros.diagnosis.model_comparison.judged_models import judged
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import by_evidence, within_reach


def free_in_one_way(pool: RefitPool, model: Hypothesis, basis: FormBasis) -> Hypothesis:
    """Return what is free in form and in each pose as free in one of these, if that does as well.

    What wanted to be another one in each pose as long as its form was the library's may not in its
    own: a reading that is off to one side is another bias wherever a body lies in the picture. And
    what wanted another form may not once it is another one in each pose: a sensor that starts anew
    has another zero each time.
    """
    in_form = tuple(own for own in model.freed if own.posture is None)
    starts = model.fit.values_by_name()
    requests = [
        RefitRequest(model.added, starts, MOST_EVALUATIONS, freed=kept)
        for kept in (in_form, _in_the_librarys_form(model))
    ]
    whole, *rest = with_refits(pool, model, requests, basis)
    as_well = [own for own in rest if _may_do_as_well(own, whole)]
    return min(as_well, key=by_evidence, default=model)


def _in_the_librarys_form(model: Hypothesis) -> tuple[Parameter, ...]:
    """Return what a model's effects are free to be in each pose, but not in other forms."""
    own = {name for added in model.added for name in added.names}
    return tuple(part for part in model.freed if part.name.partition('@')[0] in own)


def _may_do_as_well(model: Hypothesis, best: Hypothesis) -> bool:
    """Tell whether a model explains as much as the best one if all is true that is in doubt."""
    at_most = model.log_evidence + FORM_DOUBT * model.leaning
    return at_most > best.level - AS_WELL * max(1.0, best.chi_square_per_patch)


def with_less_freedom(
    pool: RefitPool, pairs: Sequence[Hypothesis], basis: FormBasis | None
) -> list[Hypothesis]:
    """Return pairs, the best one fitted in the library's form where that is better.

    Alone an effect may have taken on a form that does what the other one does: a lens can stand in
    for a bend. Fitted on with both, the two share what only one of them does.

    Args:
        pool: who refitted them, and what the nominal model is.
        pairs: judged.
        basis: see `freed_effects.with_those_freed`.
    """
    if basis is None or not pairs:
        return list(pairs)
    best, *others = sorted(pairs, key=by_evidence)
    kept = _in_the_librarys_form(best)
    if len(kept) == len(best.freed):
        return [best, *others]
    request = RefitRequest(
        best.added, best.fit.values_by_name(), MOST_EVALUATIONS, within_reach([best]), kept
    )
    both = with_refits(pool, best, [request], basis)
    return [*judged([min(both, key=by_evidence)], basis, is_brief=True), *others]
