# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models selected beside a nominal fit; once more, where they show what it did not know."""

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.borders_seen import with_borders_seen_beside, with_none_seen
from diffcal_ros.diagnosis.examined import Examined, examined, examined_anew
from diffcal_ros.diagnosis.model_comparison.bodies_of_pairs import bodies_of_pairs
from diffcal_ros.diagnosis.model_comparison.processes import Processes
from diffcal_ros.diagnosis.model_comparison.refit_pool import Progress, RefitPool
from diffcal_ros.diagnosis.model_comparison.selection import begin, Begun, select, Selection
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.settings import DiagnosisSettings
from diffcal_ros.scene.model import Scene
import numpy as np

# A nominal fit, and models beside it.
_Selected = tuple[Examined, Selection]


def selected(
    stated: Scene,
    judged: Examined,
    settings: DiagnosisSettings,
    report: Progress,
    processes: Processes | None,
) -> _Selected:
    """Refit models; once more, where a border shows beside half of the best two effects.

    What showed beside the body as it was given may be somewhere else on that one.

    Args:
        stated: the scene as it was given.
        judged: the nominal fit.
        settings: of the diagnosis.
        report: called with what is being done.
        processes: that were begun already; None: none were.
    """
    found = _selected_beside(judged, settings, report, processes)
    if not found[1].pairs:
        return found
    evaluator, nominal = with_none_seen(stated, judged.evaluator, judged.nominal)
    bodies = bodies_of_pairs(evaluator, nominal, found[1].pairs)
    known = with_borders_seen_beside(bodies, evaluator, nominal)
    if known is None or known[0].model.scene.effects == found[0].evaluator.model.scene.effects:
        return found
    again = _selected_beside(_examined_knowing(known, settings, report), settings, report)
    return min(found, again, key=_left_by_best)


def _selected_beside(
    judged: Examined,
    settings: DiagnosisSettings,
    report: Progress,
    processes: Processes | None = None,
) -> _Selected:
    """Refit models; once more, where beside those of one effect a border or more noise shows.

    Each time it is known where materials end, or a smooth error that is much larger.
    """
    with RefitPool(
        judged.evaluator, judged.nominal, report, jobs=settings.jobs, processes=processes
    ) as pool:
        begun = begin(pool, judged.scores, in_any_form=judged.disagreement.may_matter)
        known = with_borders_seen_beside(begun.singles, judged.evaluator, judged.nominal)
        if known is None:
            again = examined_anew(judged, begun.singles, settings, report)
        else:
            again = _examined_knowing(known, settings, report)
        if again is None:
            return judged, _select(pool, judged, begun)
    if not again.disagreement.is_worth_naming:
        return again, Selection(())
    return _selected_beside(again, settings, report)


def _examined_knowing(
    known: tuple[PatchEvaluator, Refit], settings: DiagnosisSettings, report: Progress
) -> Examined:
    """Examine a scene that knows where what a camera reads ends."""
    report('parts of the surface are read otherwise: once more, with those known')
    return examined(*known, settings, report)


def _left_by_best(found: _Selected) -> float:
    """Return chi-square per patch of the best of the models that were selected."""
    best = found[1].best
    return np.inf if best is None else best.chi_square_per_patch


def _select(pool: RefitPool, judged: Examined, begun: Begun | None = None) -> Selection:
    """Select models; a gap that does not matter has no name, and no second one."""
    return select(
        pool,
        judged.scores,
        begun,
        with_pairs=judged.disagreement.verdict is Verdict.DISAGREE,
        in_any_form=judged.disagreement.may_matter,
    )
