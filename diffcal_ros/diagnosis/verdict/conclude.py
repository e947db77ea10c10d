# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From refitted models to a verdict."""

from collections.abc import Sequence

from diffcal_ros.diagnosis.answers import Evidence
from diffcal_ros.diagnosis.detection.disagreement import Disagreement
from diffcal_ros.diagnosis.detection.limits import Drawn, drawn_parameters, upper_limits
from diffcal_ros.diagnosis.detection.local_outlier import LocalOutlier
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.parameters_in_any_form import in_any_form
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.residual_location import where_largest
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.screening import largest_cosines, Screen
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.naming import find_name, Naming
from diffcal_ros.diagnosis.verdict.notes import notes_of
from diffcal_ros.diagnosis.verdict.time_course import time_course
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis
from diffcal_ros.diagnosis.verdict.verdict_figures import (
    details_of,
    drawn_beside,
    gap_figures,
    parameter_table,
    times_detectable,
    weight_doubt,
)
from diffcal_ros.effects.registry import what_settles


def conclude(
    evaluator: PatchEvaluator,
    nominal: Refit,
    scores: Screen,
    disagreement: Disagreement,
    selection: Selection | None,
    choice: Choice | None,
    seconds: float,
    outliers: Sequence[LocalOutlier] = (),
    witness: FieldWitness | None = None,
) -> Diagnosis:
    """Put the verdict together."""
    witness = witness or FieldWitness(evaluator, nominal)
    added, fitted, doubt = nominal, nominal, 0.0
    if choice is not None:
        added, fitted = choice.hypothesis.fit, in_any_form(choice.hypothesis, nominal)
        doubt = weight_doubt(choice.hypothesis)
    singles = () if selection is None else selection.singles
    named = find_name(evaluator, nominal, scores, disagreement, choice, singles, witness)
    unknown, factor = named.unknown, disagreement.error_factor
    return Diagnosis(
        verdict=disagreement.verdict,
        evidence=Evidence.CONFIRMED if evaluator.is_measured else Evidence.SUSPECTED,
        p_value=disagreement.p_value,
        effects=named.effects,
        ambiguity_set=() if choice is None or named.is_open else choice.alike,
        runner_up=None if choice is None else choice.runner_up,
        unknown_class=None if unknown is None else unknown.groups[0],
        unknown_classes=() if unknown is None else unknown.groups,
        stand_in=None if unknown is None else unknown.stand_in,
        separating_recording=_separating_recording(choice, named),
        where=where_largest(evaluator.model, nominal),
        when=time_course(evaluator.model, nominal),
        gap_mm=gap_figures(nominal, added),
        closure=named.closure,
        parameters={
            'before': parameter_table(nominal, nominal, error_factor=factor),
            'after': parameter_table(
                fitted,
                nominal,
                weight_doubt=doubt,
                is_known=unknown is None,
                error_factor=factor,
            ),
        },
        times_detectable=times_detectable(scores),
        limits=upper_limits(scores),
        drawn=_drawn(nominal, scores, choice if named.effects else None),
        largest_cosine=largest_cosines(scores.scores),
        seconds=seconds,
        notes=notes_of(evaluator, nominal, disagreement, choice, named, outliers),
        details=details_of(nominal, scores, selection, choice),
    )


def _drawn(nominal: Refit, scores: Screen, named: Choice | None) -> Drawn:
    """Return how far what hides may have drawn parameters, beside what is named or as before."""
    if named is None:
        return drawn_parameters(scores, nominal.parameters)
    return drawn_beside(named.hypothesis, scores)


def _separating_recording(choice: Choice | None, named: Naming) -> str | None:
    """Say what to record to settle a doubt, where there is one that a recording settles."""
    if choice is not None and not named.doubts and (len(choice.alike) > 1 or choice.unsure):
        return what_settles(choice.alike[:3])
    return what_settles(named.imitated) if named.imitated else None
