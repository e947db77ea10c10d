# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that are other ones in the course of a recording.

A camera warms up or is bumped, a table sways, a driver's stamps jump: as the same at all times
such an effect explains next to nothing, and another one may come nearer. So what amplitudes are
more goes straight from knot to knot, normal about zero at each and as large as the data favour;
stamps may be others in each frame besides. Frames that no fit has seen lie between knots that the
frames beside them tell.
"""

from collections.abc import Sequence
from itertools import compress

from diffcal_ros.calibration.parameters.form_parameters import course_parameters, knot_parameter
from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.form_sizes import with_favoured_sizes
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.promised_fits import fitted_as_promised
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import best_of_each, by_evidence
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import Screen
from diffcal_ros.time_knot import knots_between, TimeKnot
import numpy as np

# Knots of a recording at most, and frames for each: every second one of a swing of half a second.
_KNOTS, _FRAMES = 9, 2
# Fewer frames tell no course.
_FEWEST = 8
# Effects that are fitted so at most.
_MOST = 2


def others_over_time(
    pool: RefitPool, scores: Screen, singles: Sequence[Hypothesis]
) -> list[Hypothesis]:
    """Return effects that are free to be others in the course of the recording, fitted.

    One look at each, where the nominal model is, says to first order which may win.

    Args:
        pool: who refit, and what the nominal model is.
        scores: of all candidates.
        singles: those that were refitted as the same at all times, best first.
    """
    times = _times(pool)
    if len(times) < _FEWEST or not pool.nominal.is_measured:
        return []
    asked = [
        RefitRequest((score.candidate,), {}, 1, freed=_course(pool, score.candidate, times))
        for score in scores.scores
        if set(score.candidate.effect.varying) & set(score.candidate.components)
    ]
    looked = pool.refit_all(asked)
    promised = [with_favoured_sizes(pool, model) for model in looked]
    best = max((single.level for single in singles), default=-np.inf)
    near = best_of_each(sorted((m for m in promised if m.level > best), key=by_evidence))[:_MOST]
    is_near = [any(model is own for own in near) for model in promised]
    fitted = fitted_as_promised(
        pool, list(compress(looked, is_near)), list(compress(promised, is_near))
    )
    return pool.finish(fitted, [-np.inf] * len(fitted))


def _times(pool: RefitPool) -> list[float]:
    """Return when the frames were taken [s]; none where there is not one recording alone."""
    seen = pool.nominal.model.observations
    times = [one.time for one in seen if one.time is not None]
    if len({one.setup_index for one in seen}) > 1 or len(times) < len(seen):
        return []
    return sorted(set(times))


def _course(
    pool: RefitPool, candidate: Candidate, times: Sequence[float]
) -> tuple[Parameter, ...]:
    """Return what amplitudes of an effect may be more around each knot, by their usual sizes."""
    model = with_effects(pool.nominal, pool.base, [candidate])[1].model
    own = [one for one in model.parameters if one.name in candidate.names]
    own += course_parameters(candidate.effect, candidate.body)
    amplitudes = [one for one in own if one.amplitude in candidate.effect.varying]
    knots = knots_between(times[0], times[-1], min(_KNOTS, 1 + len(times) // _FRAMES))
    if candidate.effect.scatters_in_time:
        apart = 0.5 * float(np.diff(times).min())
        knots = (*knots, *(TimeKnot(time, apart) for time in times))
    return tuple(knot_parameter(one, knot, 1.0) for one in amplitudes for knot in knots)
