# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models whose effects are other ones in each pose, or in another form than the library's.

As long as a clamp that was elsewhere in each pose is fitted as the same one in all, what differs
draws the other parameters: it drew a modulus by 40 %. To judge that fit with a tolerance for it
says so, and does not lead back: it is too far for one step. The same is true of a body that is
bent at rest by another curve than an arc. So what an effect is more in each posture, and in other
forms (`Effect.forms`), are nuisances, normal about zero and as large as the data favour, and all
is fitted from there.
"""

from collections.abc import Sequence

from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.freed_rivals import with_its_rival_freed
from diffcal_ros.diagnosis.model_comparison.freedom import (
    freed_parts,
    freeing_request,
    with_refits,
)
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, LEAST_LEANING
from diffcal_ros.diagnosis.model_comparison.judged_models import judged
from diffcal_ros.diagnosis.model_comparison.less_freedom import free_in_one_way
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_rounds import best_of_each, by_evidence
import numpy as np

# Models that are fitted so at most, with one effect and with two.
_MOST_SINGLES, _MOST_PAIRS = 2, 1


def with_those_freed(
    pool: RefitPool,
    models: Sequence[Hypothesis],
    basis: FormBasis | None,
    rivals: Sequence[Hypothesis] = (),
) -> list[Hypothesis]:
    """Return models, those that may win by it fitted with effects that are free to be others.

    Args:
        pool: who refitted them, and what the nominal model is.
        models: judged, with as many effects each.
        basis: by which forms are told; None: models are judged as they are, and stay so.
        rivals: other models, judged.
    """
    if basis is None or not models:
        return list(models)
    best = max(model.level for model in (*models, *rivals))
    ordered = sorted(models, key=by_evidence)
    most = _MOST_SINGLES if len(ordered[0].added) == 1 else _MOST_PAIRS
    asked = [model for model in best_of_each(ordered) if _may_win(model, best)][:most]
    better: dict[int, Hypothesis] = {}
    for model in asked:
        # Where the one before it left noise, another one seldom may.
        better[id(model)] = freed = _freed_as_it_wants(pool, model, basis, best)
        best = max(best, freed.level)
    first, *others = sorted((better.get(id(m), m) for m in models), key=by_evidence)
    first = _to_the_end(pool, first, basis)
    if first.is_free_in_everything:
        first = free_in_one_way(pool, first, basis)
    return with_its_rival_freed(pool, sorted([first, *others], key=by_evidence), basis)


def _freed_as_it_wants(
    pool: RefitPool, model: Hypothesis, basis: FormBasis, best: float
) -> Hypothesis:
    """Return a model fitted with effects that are free to be others, as long as it is better so.

    What is another one in each pose may show only once its form is free, and the other way round.
    """
    while _may_win(model, best):
        before, *found = with_refits(pool, model, [freeing_request(model)], basis)
        if not found or found[0].level <= before.level:
            break
        model = found[0]
    return model


def _may_win(model: Hypothesis, best: float) -> bool:
    """Tell whether a model's effects want to be free, and would win if that left noise.

    Args:
        model: judged.
        best: level of the best of all.
    """
    judged = model.judged
    if judged is None or model.leaning < LEAST_LEANING or not freed_parts(model):
        return False
    # What forms explain to first order is in the log evidence. A fit may leave noise alone.
    left = max(judged.chi_square - judged.freedom, 0.0)
    return model.log_evidence + 0.5 * left >= best


def _to_the_end(pool: RefitPool, model: Hypothesis, basis: FormBasis) -> Hypothesis:
    """Return the best model fitted on, where its effects are free and evaluations ran out.

    How much it closes is told where it stands, however near one more step leads.
    """
    if not model.freed or model.fit.is_converged or model.leaning < LEAST_LEANING:
        return model
    ended = judged(pool.finish([model], [-np.inf]), basis, is_brief=True)[0]
    return ended if ended.fit.chi_square < model.fit.chi_square else model
