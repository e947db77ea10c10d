# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refitted models with a tolerance, and witnesses with predictions, that a test chooses."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.any_form import Tolerated
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.screening.shortlist import starts_of
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.frame_test import ClassScore


def refitted_with(screened: tuple, *identifiers: str) -> Hypothesis:
    """Return the nominal model with effects, refitted from where tangents lead the first.

    Args:
        screened: evaluator and fit of the nominal model, and scores.
        identifiers: of the effects.
    """
    evaluator, nominal, scores = screened
    added = [next(s for s in scores.scores if s.candidate.identifier == n) for n in identifiers]
    return try_effects(evaluator, nominal, [s.candidate for s in added], starts_of(added[0]))


def with_judgement(model: Hypothesis, **changes: float) -> Hypothesis:
    """Return a model that leaves more than noise, and owes much to other forms than the library's.

    Args:
        model: refitted.
        changes: of `Tolerated`.
    """
    own = Tolerated(
        log_evidence=model.fit.log_evidence,
        log_prediction=0.0,
        fraction=0.05,
        by_pose=0.05,
        left=2e-4,
        chi_square=model.fit.chi_square,
        freedom=float(model.fit.patch_count),
        exact=model.fit.log_evidence - 80.0,
        coordinates=model.fit.coordinates,
        covariance=model.fit.covariance,
    )
    fit = replace(model.fit, chi_square=3.0 * model.fit.patch_count)
    return replace(model, fit=fit, judged=replace(own, **changes))


def witness_of(screened: tuple, **predictions: float) -> FieldWitness:
    """Return a witness of whose fields predictions are known.

    Args:
        screened: evaluator and fit of the nominal model, and scores.
        predictions: log densities by class.
    """
    evaluator, nominal, _ = screened
    witness = FieldWitness(evaluator, nominal)
    ordered = sorted(predictions.items(), key=lambda own: -own[1])
    witness.scores = tuple(ClassScore(group, value, 1.0, 0.5) for group, value in ordered)
    return witness
