# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refits in rounds: a brief look at each model, and those to the end that may still win."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.patch_fits.patch_fit import FROM_A_FIT, HOPE, Pace
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Score
from diffcal_ros.diagnosis.screening.shortlist import starts_of
import numpy as np

# Evaluations of the model in a first request, and where one of the effects needs a long one; and
# how far behind in log evidence per unit of noise scale a model may then be to be fitted on.
_BRIEF, _LONG = 4, 8
# So many times a model that ran out of evaluations, and may still win, is fitted on.
_ROUNDS = 2
_OUT_OF_REACH = 40.0

# Judges fitted models with a tolerance for the form of their effects, in their order.
Judge = Callable[[Sequence[Hypothesis]], list[Hypothesis]]


def first_request(
    added: Sequence[Candidate], starts: dict[str, float], rivals: Sequence[Hypothesis] = ()
) -> RefitRequest:
    """Return a brief refit, given up where it will hardly come near its rivals."""
    most = _LONG if any(candidate.effect.needs_long_look for candidate in added) else _BRIEF
    return RefitRequest(tuple(added), starts, most, within_reach(rivals))


def request_beside(
    one: Mapping[str, float],
    added: Sequence[Candidate],
    score: Score,
    rivals: Sequence[Hypothesis],
    freed: tuple[Parameter, ...],
    pace: Pace = FROM_A_FIT,
) -> RefitRequest:
    """Return a brief refit of a fitted effect and a second one, from where there is none of that.

    Where tangents lead all parameters move: the second one alone, as far, would lead a model of
    -2288 in log evidence to -8363.

    Args:
        one: where the fitted model is, SI units by name.
        added: both.
        score: of the second.
        rivals: others that it is held against.
        freed: what the fitted effect is besides.
        pace: of a fit that begins there.
    """
    request = first_request(added, {**one, **score.candidate.screened}, rivals)
    return replace(request, freed=freed, expected=starts_of(score), pace=pace)


def within_reach(rivals: Sequence[Hypothesis]) -> float:
    """Return the log evidence below which a model is out of reach of the best of others."""
    if not rivals:
        return -np.inf
    scale = max(1.0, min(h.fit.chi_square_per_patch for h in rivals))
    return max(h.fit.log_evidence for h in rivals) - _OUT_OF_REACH * scale


def finished(
    pool: RefitPool,
    brief: Sequence[Hypothesis],
    front: frozenset[str] = frozenset(),
    rivals: Sequence[Hypothesis] = (),
    late: Sequence[RefitRequest] = (),
    judge: Judge | None = None,
) -> list[Hypothesis]:
    """Fit the models that may still win, or lead by their scores, to the end; best first.

    What effects in another form leave in the library's no further step of that takes away: judged
    with a tolerance for forms a model has such a step behind it, and most need none.

    Args:
        pool: who refit.
        brief: models after a brief look.
        front: identifiers of those that lead by their scores.
        rivals: others that they are held against.
        late: looks that are given up where they will hardly come near any of these.
        judge: by whom it is told which may still win; None: their log evidence does.
    """
    models = list(brief)
    reach = within_reach([*models, *rivals])
    late = [replace(request, least_log_evidence=reach) for request in late]
    for _ in range(_ROUNDS + bool(late)):
        worth = _worth_going_on(models, rivals, front, judge)
        begun, further = pool.finish_beside(
            late, [models[index] for index in worth], list(worth.values())
        )
        for index, hypothesis in zip(worth, further, strict=True):
            models[index] = hypothesis
        models += begun
        # A twin that ran out of evaluations is no reason to be sure of the other one.
        front, late = frozenset(), ()
    return sorted(models, key=by_evidence)


def with_more(
    pool: RefitPool,
    models: Sequence[Hypothesis],
    requests: Sequence[RefitRequest],
    rivals: Sequence[Hypothesis],
    judge: Judge | None,
) -> list[Hypothesis]:
    """Return models and others that are refitted, best first.

    Args:
        pool: who refit.
        models: that were.
        requests: for the others.
        rivals: what those are held against besides.
        judge: see `finished`.
    """
    more = finished(pool, pool.refit_all(requests), rivals=[*rivals, *models], judge=judge)
    return sorted([*models, *more], key=by_evidence)


def _worth_going_on(
    models: Sequence[Hypothesis],
    rivals: Sequence[Hypothesis],
    front: frozenset[str],
    judge: Judge | None,
) -> dict[int, float]:
    """Return which models may still win, and the log evidence below which each is of no use."""
    going = [index for index, model in enumerate(models) if not model.fit.is_converged]
    if not going:
        return {}
    if judge is not None:
        near = are_in_reach(models, rivals, judge)
        # Halfway down a front runner is judged by forms where it happens to stand.
        leading = [bool(front & set(model.identifiers)) for model in models]
        return {index: -np.inf for index in going if near[index] or leading[index]}
    reach = within_reach([*models, *rivals])
    leasts = {
        index: -np.inf if front & set(models[index].identifiers) else reach for index in going
    }
    # After a brief look a model may be far behind, and halfway down.
    return {
        index: least
        for index, least in leasts.items()
        if models[index].fit.log_evidence + HOPE * models[index].fit.promise >= least
    }


def are_in_reach(
    models: Sequence[Hypothesis], rivals: Sequence[Hypothesis], judge: Judge
) -> list[bool]:
    """Tell of each model whether it may still win in whatever form.

    Args:
        models: that were looked at, at least one.
        rivals: others that they are held against.
        judge: judges all of them.
    """
    judged = judge([*models, *rivals])
    best = min(judged, key=by_evidence)
    least = least_level(best)
    return [model.level >= least for model in judged[: len(models)]]


def least_level(best: Hypothesis) -> float:
    """Return the level below which judged models are out of reach of the best one."""
    return best.level - _OUT_OF_REACH * max(1.0, best.chi_square_per_patch)


def by_evidence(hypothesis: Hypothesis) -> tuple[bool, float]:
    """Order models by evidence, the best first, those at a bound last."""
    return hypothesis.is_at_bound, -hypothesis.level


def best_of_each(models: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return the first model of each set of effects, of models in order."""
    found: dict[tuple[str, ...], Hypothesis] = {}
    for model in models:
        found.setdefault(model.identifiers, model)
    return list(found.values())
