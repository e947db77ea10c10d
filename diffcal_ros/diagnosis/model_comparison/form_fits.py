# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models where a fit that knows of forms would have them.

An effect of another form, fitted in the library's, comes to rest beside its truth, and the other
parameters with it. One step with the form free leads to where it belongs.
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.any_form import led_by_form
from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.patch_fits.refit import Refit, refit
from diffcal_ros.diagnosis.screening.candidates import Candidate, parameters_of
from diffcal_ros.errors import NotSimulatedError
import numpy as np

# Of the patches that a pair sees one of its effects alone must see as many.
_SEEN = 0.9


def each_alone(pool: RefitPool, pair: Hypothesis, basis: FormBasis) -> list[Hypothesis]:
    """Return each effect of a pair alone: what the other one explains may be its own form.

    Args:
        pool: who refitted it, and what the nominal model is.
        pair: model with two effects.
        basis: what forms are told by.
    """
    found = [_led(pool, pair, [own], basis) for own in pair.added]
    return [model for model in found if model is not None and _is_sound(model, pair, pool.base)]


def _is_sound(model: Hypothesis, pair: Hypothesis, base: Refit) -> bool:
    """Tell whether a step led anywhere: it is better than nothing, and the body is still in view.

    What has lost its patches leaves little, and nothing could be compared beside it.
    """
    is_seen = model.fit.patch_count > _SEEN * pair.fit.patch_count
    return is_seen and model.fit.chi_square < base.chi_square


def one_of_each(models: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return models of which none has the same effects and amplitudes, in their order.

    Of several that differ in where they stand the first stays, with what is said of the best: how
    far the library's form leads is told where that has been fitted.
    """
    found: dict[tuple[tuple[Candidate, ...], bool], Hypothesis] = {}
    for model in models:
        key = model.added, bool(model.freed)
        before = found.setdefault(key, model)
        if model.level > before.level:
            found[key] = replace(before, judged=model.judged)
    return list(found.values())


def _led(
    pool: RefitPool, model: Hypothesis, kept: Sequence[Candidate], basis: FormBasis
) -> Hypothesis | None:
    ways = ways_of(model.evaluator.model, model.fit, basis, kept)
    gone = parameters_of(model.fit.parameters, [own for own in model.added if own not in kept])
    values = dict(zip(model.fit.parameters.names, led_by_form(model.fit, ways, gone), strict=True))
    more = tuple(own for own in model.freed if own.name not in gone)
    scene, evaluator = with_effects(pool.nominal, pool.base, kept, more)
    start = np.array([values[name] for name in evaluator.model.parameters.names])
    try:
        fit = refit(evaluator, start, max_iterations=1)
    except NotSimulatedError:
        return None
    return replace(
        model, added=tuple(kept), scene=scene, evaluator=evaluator, fit=fit, judged=None
    )
