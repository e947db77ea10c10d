# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models where their fits are, not where tangents promised them.

What data favour of a free form is told to first order, and so is where a fit with that would end.
A camera that is free in form and in each pose stood promised at a log evidence of -986, and was at
-3628 there: no other model came near a promise, and none that began from it led anywhere.
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.hypothesis import AS_WELL, Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.patch_fits.patch_fit import FROM_A_FIT
from diffcal_ros.diagnosis.patch_fits.refit import weighed_anew
import numpy as np

# Evaluations of the model where a promise was not kept.
_EVALUATIONS = 4


def fitted_as_promised(
    pool: RefitPool, before: Sequence[Hypothesis], promised: Sequence[Hypothesis]
) -> list[Hypothesis]:
    """Return models fitted where steps lead, those that win nothing by it as they were.

    One that is where its step promised stays there. Another one is fitted on from there or from
    where it was, whichever is better.

    Args:
        pool: who refitted them, and what the nominal model is.
        before: the step, fitted.
        promised: the same parameters with other things known of them beforehand, to first order;
            one that is the same model was not changed.
    """
    found = list(before)
    changed = [n for n, model in enumerate(promised) if model is not before[n]]
    if not changed:
        return found
    looked = pool.look([promised[n] for n in changed])
    broken: dict[int, Hypothesis] = {}
    for n, there in zip(changed, looked, strict=True):
        if there is not None and _is_kept(promised[n], there):
            found[n] = there
            continue
        anew = weighed_anew(before[n].fit, promised[n].evaluator)
        stayed = replace(promised[n], fit=replace(anew, pace=FROM_A_FIT))
        broken[n] = stayed if there is None else max(there, stayed, key=_by_patch)
    if not broken:
        return found
    further = pool.finish(list(broken.values()), [-np.inf] * len(broken), _EVALUATIONS)
    for n, model in zip(broken, further, strict=True):
        found[n] = max(before[n], model, key=_by_patch)
    return found


def _is_kept(promised: Hypothesis, there: Hypothesis) -> bool:
    """Tell whether a model is about as good where a step leads as that promised."""
    margin = AS_WELL * max(1.0, there.fit.chi_square_per_patch)
    return there.fit.log_evidence > promised.fit.log_evidence - margin


def _by_patch(model: Hypothesis) -> float:
    """Return by what places of one model are compared: from some it sees fewer patches."""
    return model.fit.log_evidence / max(model.fit.patch_count, 1)
