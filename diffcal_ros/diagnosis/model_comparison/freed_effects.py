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

from diffcal_ros.calibration.parameters.form_parameters import form_parameters, posture_parameters
from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_sizes import with_favoured_sizes
from diffcal_ros.diagnosis.model_comparison.hypothesis import (
    AS_WELL,
    FORM_DOUBT,
    Hypothesis,
    LEAST_LEANING,
)
from diffcal_ros.diagnosis.model_comparison.judged_models import judged
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import (
    best_of_each,
    by_evidence,
    least_level,
    within_reach,
)
from diffcal_ros.diagnosis.screening.candidates import Candidate
import numpy as np

# Of what an effect does: what data say that differs by less is as well judged as fitted. A tenth
# is one of the shares that are tried, and their mean may be a little less.
_LEAST_SHARE = 0.09
# By so much of what it owes to forms a model may be better once they are fitted: mostly by 0.1 to
# 0.3, and by 1.6 where the first step was far off.
_LED_ON = 0.4
# Rivals that are freed, one after the other overtaking the best.
_OVERTAKEN = 2
# Models that are fitted so at most, with one effect and with two, and evaluations of each.
_MOST_SINGLES, _MOST_PAIRS, _MOST_EVALUATIONS = 2, 1, 6


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
        first = _free_in_one_way(pool, first, basis)
    return _with_its_rival_freed(pool, sorted([first, *others], key=by_evidence), basis)


def _with_its_rival_freed(
    pool: RefitPool, models: Sequence[Hypothesis], basis: FormBasis
) -> list[Hypothesis]:
    """Return models, the nearest rival of the best one free in form, where that may decide.

    To first order it may owe next to nothing to forms, and be far better in one: where a body is
    eight times stiffer at one end than at the other nothing is linear. So it is free where the
    best one is, and where a form that is fitted may bring it near: a body that was propped up is
    bent along its inner half, and a clamp that is turned comes near in the library's form. What it
    overtakes so is free as well.

    Args:
        pool: see `with_those_freed`.
        models: judged, best first.
        basis: see `with_those_freed`.
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
        if _freed(rival, _LEAST_SHARE) or (rival.freed and not rival.fit.is_converged):
            both = _with_refit(pool, rival, _request(rival, _LEAST_SHARE), basis)
            others[place] = min(both, key=by_evidence)
            return sorted([first, *others], key=by_evidence)
    return list(models)


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
        pool: see `with_those_freed`.
        singles: models with one effect each, judged, best first.
        pairs: with two, judged.
        basis: see `with_those_freed`.
    """
    if basis is None or not (singles and pairs):
        return list(singles)
    best = min(pairs, key=by_evidence)
    if best.level <= singles[0].level:
        return list(singles)
    requests = [
        _request(single, _LEAST_SHARE)
        for single in best_of_each(singles)
        if single.identifiers[0] in best.identifiers
        and not (single.is_at_bound or single.is_free_in_form)
        and _freed(single, _LEAST_SHARE)
    ]
    if not requests:
        return list(singles)
    found = [with_favoured_sizes(pool, own) for own in pool.refit_all(requests)]
    return sorted([*singles, *judged(found, basis, is_brief=True)], key=by_evidence)


def _may_come_near(rival: Hypothesis, first: Hypothesis) -> bool:
    """Tell whether a model free in form may explain about as much as the best one.

    By what forms owed it to first order is better once they are fitted, or by leaving noise alone.
    """
    judged = rival.judged
    if judged is None:
        return False
    if first.freed and rival.level > least_level(first):
        return True
    left = max(judged.chi_square - judged.freedom, 0.0)
    led_on = rival.level + _LED_ON * max(rival.leaning, 0.0)
    at_most = max(led_on, rival.log_evidence + 0.5 * left)
    return at_most > first.level - AS_WELL * max(1.0, first.chi_square_per_patch)


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
        basis: see `with_those_freed`.
    """
    if basis is None or not pairs:
        return list(pairs)
    best, *others = sorted(pairs, key=by_evidence)
    own = {name for added in best.added for name in added.names}
    kept = tuple(part for part in best.freed if part.name.partition('@')[0] in own)
    if len(kept) == len(best.freed):
        return [best, *others]
    request = RefitRequest(
        best.added, best.fit.values_by_name(), _MOST_EVALUATIONS, within_reach([best]), kept
    )
    both = _with_refit(pool, best, request, basis)
    return [*judged([min(both, key=by_evidence)], basis, is_brief=True), *others]


def _to_the_end(pool: RefitPool, model: Hypothesis, basis: FormBasis) -> Hypothesis:
    """Return the best model fitted on, where its effects are free and evaluations ran out.

    How much it closes is told where it stands, however near one more step leads.
    """
    if not model.freed or model.fit.is_converged or model.leaning < LEAST_LEANING:
        return model
    ended = judged(pool.finish([model], [-np.inf]), basis, is_brief=True)[0]
    return ended if ended.fit.chi_square < model.fit.chi_square else model


def _free_in_one_way(pool: RefitPool, model: Hypothesis, basis: FormBasis) -> Hypothesis:
    """Return what is free in form and in each pose as free in one of these, if that does as well.

    What wanted to be another one in each pose as long as its form was the library's may not in its
    own: a reading that is off to one side is another bias wherever a body lies in the picture. And
    what wanted another form may not once it is another one in each pose: a sensor that starts anew
    has another zero each time.
    """
    named = {name for added in model.added for name in added.names}
    in_form = tuple(own for own in model.freed if own.posture is None)
    in_poses = tuple(
        own
        for own in model.freed
        if own.posture is not None and own.name.partition('@')[0] in named
    )
    starts = model.fit.values_by_name()
    requests = [
        RefitRequest(model.added, starts, _MOST_EVALUATIONS, freed=kept)
        for kept in (in_form, in_poses)
    ]
    found = [with_favoured_sizes(pool, own) for own in pool.refit_all(requests)]
    whole, *rest = judged([model, *found], basis, is_brief=True)
    as_well = [own for own in rest if _may_do_as_well(own, whole)]
    return min(as_well, key=by_evidence, default=model)


def _freed_as_it_wants(
    pool: RefitPool, model: Hypothesis, basis: FormBasis, best: float
) -> Hypothesis:
    """Return a model fitted with effects that are free to be others, as long as it is better so.

    What is another one in each pose may show only once its form is free, and the other way round.
    """
    while _may_win(model, best):
        before, *found = _with_refit(pool, model, _request(model), basis)
        if not found or found[0].level <= before.level:
            break
        model = found[0]
    return model


def _with_refit(
    pool: RefitPool, model: Hypothesis, request: RefitRequest, basis: FormBasis
) -> list[Hypothesis]:
    """Return a model and its refit, if that can be simulated, judged on the patches both see."""
    found = [with_favoured_sizes(pool, own) for own in pool.refit_all([request])]
    return judged([model, *found], basis, is_brief=True)


def _request(model: Hypothesis, least_fraction: float = 0.0) -> RefitRequest:
    """Return the refit of a model whose effects are free where they want to be.

    Args:
        model: judged.
        least_fraction: by how much of itself each may be of another form at least.
    """
    return RefitRequest(
        model.added,
        model.fit.values_by_name(),
        _MOST_EVALUATIONS,
        freed=(*model.freed, *_freed(model, least_fraction)),
    )


def _may_win(model: Hypothesis, best: float) -> bool:
    """Tell whether a model's effects want to be free, and would win if that left noise.

    Args:
        model: judged.
        best: level of the best of all.
    """
    judged = model.judged
    if judged is None or model.leaning < LEAST_LEANING or not _freed(model):
        return False
    # What forms explain to first order is in the log evidence. A fit may leave noise alone.
    left = max(judged.chi_square - judged.freedom, 0.0)
    return model.log_evidence + 0.5 * left >= best


def _freed(model: Hypothesis, least_fraction: float = 0.0) -> list[Parameter]:
    """Return what a model's effects may be besides in each posture, and in other forms.

    See `_request`.
    """
    judged, found = model.judged, list[Parameter]()
    if judged is None:
        return found
    known = model.fit.parameters
    for added in model.added:
        effect, size = added.effect, _size(model, added)
        if size == 0.0:
            continue  # What is not there is of no other form either.
        is_moved = effect.most_by_pose >= 1.0
        if is_moved and judged.by_pose >= _LEAST_SHARE:
            found += _in_each(model, added.names, judged.by_pose * size)
        fraction = max(judged.fraction, least_fraction)
        if fraction >= _LEAST_SHARE:
            form = form_parameters(effect, fraction * size)
            names = [own.name for own in form]
            if not set(names) <= set(known.names):
                found += form
            elif is_moved and len(model.evaluator.model.bodies) > 1:
                # Its form is free, and still it is another one: in each pose, then.
                found += _in_each(model, names, fraction * size)
    return [parameter for parameter in found if parameter.name not in known.names]


def _in_each(model: Hypothesis, names: Sequence[str], size: float) -> list[Parameter]:
    """Return what parameters of a model are more in each posture."""
    known = model.fit.parameters
    amplitudes = [known.parameters[known.names.index(name)] for name in names]
    return posture_parameters(amplitudes, model.evaluator.model.bodies, size)


def _size(model: Hypothesis, added: Candidate) -> float:
    """Return how large the amplitudes of a fitted effect are, in usual sizes; 1 of a place."""
    if not added.effect.has_tangent:
        return 1.0
    places = [model.fit.parameters.names.index(name) for name in added.names]
    return float(np.linalg.norm(model.fit.coordinates[places] / added.scales))
