# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that scores put far behind, and that may win in another form than the library's.

Scores know the library's form around the nominal fit. An error of depth whose border runs
otherwise explains little in that, and more than any other effect in its own. A mass that dries
from pose to pose has drawn the modulus, and explains a sixth of what a plane does in any form. A
step of depth that a robust fit has left out stays out as long as patches are fitted from there: it
explains nothing to first order, and is seen. A body that is twisted at rest is bent by no arc.

What leaves noise only since it is free to be another one in form, or in each pose, says nothing
against others with the same freedom: a body that rattles in its clamp turns another way in each
pose, which tangents of one displacement in all of them do not see, and a clamp that gives way by
another law in each pose follows it.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import compress

from diffcal_ros.calibration.parameters.form_parameters import form_parameters, posture_parameters
from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.absence import has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.form_sizes import with_favoured_sizes
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, LEAST_LEANING
from diffcal_ros.diagnosis.model_comparison.promised_fits import fitted_as_promised
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import are_in_reach, first_request, Judge
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Score, Screen
from diffcal_ros.diagnosis.screening.shortlist import distinct, starts_of, with_tangents
from diffcal_ros.diagnosis.screening.starts import more_starts
import numpy as np

# Who explains less than this share of what the best one could does so in no form.
_SEEN_AT_ALL = 0.05
# With its form free an effect must explain this share of what the best one does to first order.
_LEADS = 0.5
# And this many times what it does in the library's form, which is looked at anyway.
_FARTHER = 2.0
# Evaluations of a look: where tangents lead at once other parameters have not followed yet.
_LOOKS, _LOOKS_FREED = 2, 4


def others_in_any_form(
    pool: RefitPool, scores: Screen, singles: Sequence[Hypothesis], judge: Judge
) -> list[Hypothesis]:
    """Return effects that were not refitted and may win in another form, fitted to the end.

    One look at each, where tangents lead, is enough to judge that, with what data favour of its
    form to first order; only those that come near are fitted there.

    Args:
        pool: who refit, and what the nominal model is.
        scores: of all candidates.
        singles: those that were refitted, judged, best first.
        judge: see `finished`.
    """
    if not singles or _is_enough(singles[0]):
        return []
    known = {identifier for single in singles for identifier in single.identifiers}
    told = {own for single in singles if _is_there(pool, single) for own in single.identifiers}
    smooth = distinct(with_tangents(scores).scores)
    most = max((score.gain for score in smooth), default=0.0)
    others = [score for score in smooth if score.candidate.identifier not in known]
    absent = [score for score in smooth if score.candidate.identifier in known - told]
    freed = _led_by_their_freedom(pool, [*others, *absent], 0.5 * most, singles[0])
    looks = [
        _look(score)
        for score in others
        if score.gain > _SEEN_AT_ALL * most or _is_seen_otherwise(pool, score.candidate)
    ]
    looked = pool.refit_all([*looks, *freed])
    if not looked:
        return []
    promised = [with_favoured_sizes(pool, model) for model in looked]
    is_near = are_in_reach(promised, singles, judge)
    near = fitted_as_promised(
        pool, list(compress(looked, is_near)), list(compress(promised, is_near))
    )
    return pool.finish(near, [-np.inf] * len(near))


def _look(score: Score) -> RefitRequest:
    request = first_request([score.candidate], starts_of(score))
    return replace(request, max_iterations=_LOOKS)


def _is_seen_otherwise(pool: RefitPool, candidate: Candidate) -> bool:
    """Tell whether an effect is seen where tangents do not lead."""
    return any(more_starts(pool.nominal, pool.base, [candidate]))


def _is_there(pool: RefitPool, single: Hypothesis) -> bool:
    """Tell whether an effect was fitted as one that is there, or is free to be another one.

    One that came to nothing in the library's form says nothing of others.
    """
    return bool(single.freed) or not has_doubtful_effect(single, pool.base)


def _is_enough(best: Hypothesis) -> bool:
    """Tell whether the best model leaves noise as the library has it, about, in all poses."""
    return best.leaves_noise and best.leaning < LEAST_LEANING and not best.freed


def _led_by_their_freedom(
    pool: RefitPool, scores: Sequence[Score], known_gain: float, best: Hypothesis
) -> list[RefitRequest]:
    """Return looks at effects that tangents of what they may be besides lead farther than most.

    Args:
        pool: see `others_in_any_form`.
        scores: of effects in the library's form.
        known_gain: half chi-square that tangents of the best effect promise in that form.
        best: of the models that were refitted: what it is in each pose others may be, too.
    """
    is_by_pose = any(own.posture is not None for own in best.freed)
    asked = [
        (0.5 * score.gain, score.candidate, freed)
        for score in scores
        for freed in _freedoms(pool, score.candidate, is_by_pose=is_by_pose)
    ]
    at_nominal = pool.refit_all([_freed(candidate, freed, 1) for _, candidate, freed in asked])
    promised = {(model.added[0], model.freed): model.fit.promise for model in at_nominal}
    least = _LEADS * max([known_gain, *promised.values()])
    return [
        _freed(candidate, freed, _LOOKS_FREED)
        for gain, candidate, freed in asked
        if promised.get((candidate, freed), 0.0) > max(least, _FARTHER * gain)
    ]


def _freedoms(
    pool: RefitPool, candidate: Candidate, *, is_by_pose: bool
) -> list[tuple[Parameter, ...]]:
    """Return what an effect may be besides: in form, and in each pose where that is asked."""
    found, effect = list[tuple[Parameter, ...]](), candidate.effect
    if effect.forms:
        found.append(tuple(form_parameters(effect, 1.0, candidate.body)))
    if is_by_pose and effect.most_by_pose >= 1.0:
        found.append(in_each_pose(pool, candidate))
    return found


def in_each_pose(pool: RefitPool, candidate: Candidate) -> tuple[Parameter, ...]:
    """Return what each amplitude of an effect may be more in each pose, by its usual size."""
    model = with_effects(pool.nominal, pool.base, [candidate])[1].model
    amplitudes = [own for own in model.parameters if own.name in candidate.names]
    return tuple(posture_parameters(amplitudes, model.bodies, 1.0))


def _freed(candidate: Candidate, freed: tuple[Parameter, ...], evaluations: int) -> RefitRequest:
    """Return the refit of an effect and what it may be besides, from where there is none of it."""
    return replace(first_request([candidate], {}), max_iterations=evaluations, freed=freed)
