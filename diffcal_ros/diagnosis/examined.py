# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether a nominal fit disagrees with what is seen, and what scores best beside it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.detection.disagreement import Disagreement, measure_disagreement
from diffcal_ros.diagnosis.detection.local_outlier import find_local_outlier, LocalOutlier
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import Progress
from diffcal_ros.diagnosis.nominal_fit import fit_patches, hides_errors, with_smooth_error
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.candidates import Candidate, candidates
from diffcal_ros.diagnosis.screening.screening import library_groups, Screen, screen
from diffcal_ros.diagnosis.settings import DiagnosisSettings

# Places that are left out at most.
_MOST_OUTLIERS = 2
# A smooth error that is larger by less moves no verdict for the time that it takes.
_MORE = 1.25


@dataclass(frozen=True)
class Examined:
    """A nominal fit, held against what is seen.

    Attributes:
        evaluator: of the nominal model.
        nominal: its fit.
        scores: of all candidates beside it.
        disagreement: whether there is one.
        expected: evaluator with the sensor's errors as they are expected beforehand.
        outliers: what was left out as not the body's.
    """

    evaluator: PatchEvaluator
    nominal: Refit
    scores: Screen
    disagreement: Disagreement
    expected: PatchEvaluator
    outliers: tuple[LocalOutlier, ...] = ()


def examined(
    evaluator: PatchEvaluator, nominal: Refit, settings: DiagnosisSettings, report: Progress
) -> Examined:
    """Score all candidates beside a nominal fit, with the smooth error that the sensor shows.

    Args:
        evaluator: of the nominal model, with the sensor's errors as they are expected beforehand.
        nominal: its fit.
        settings: of the diagnosis.
        report: called with what is being done.
    """
    seen, nominal = with_smooth_error(evaluator, nominal)
    return _examined_by(evaluator, seen, nominal, settings, report)


def examined_anew(
    judged: Examined,
    models: Sequence[Hypothesis],
    settings: DiagnosisSettings,
    report: Progress,
) -> Examined | None:
    """Examine by the smooth error that the sensor shows beside the best model of one effect.

    Beside a gap far above the floors it is hidden, and no more of it is believed than is expected
    of any sensor (`with_smooth_error`). What the best model leaves may not hide it: of that all
    other effects of the library may have put there what they may.

    Args:
        judged: the nominal fit.
        models: with one effect each, best first.
        settings: of the diagnosis.
        report: called with what is being done.

    Returns:
        None where it was not hidden or still is, or is hardly more than was believed.
    """
    if not (models and judged.expected.tells_smooth_error and hides_errors(judged.nominal)):
        return None
    best = models[0]
    if hides_errors(best.fit):
        return None
    error = _with_error_beside(best, judged.expected)
    known = judged.evaluator
    if error.smooth_error <= _MORE * known.smooth_error:
        return None
    report(f'the sensor has a smooth error of {1e3 * error.smooth_error:.2f} mm: once more')
    evaluator = known.with_noise_of(error)
    nominal = fit_patches(evaluator, judged.nominal.coordinates)
    found = _examined_by(judged.expected, evaluator, nominal, settings, report)
    return replace(found, outliers=(*judged.outliers, *found.outliers))


def _with_error_beside(model: Hypothesis, expected: PatchEvaluator) -> PatchEvaluator:
    """Return the evaluator of a model, with the smooth error that the sensor shows beside it.

    Args:
        model: with effects.
        expected: evaluator with the sensor's errors as they are expected beforehand.
    """
    evaluator = model.evaluator.with_noise_of(expected)
    others = [
        own for own in candidates(evaluator.model.scene) if own.identifier not in model.identifiers
    ]
    _, groups = library_groups(evaluator, model.fit.coordinates, others)
    return evaluator.with_smooth_error(groups)


def _examined_by(
    expected: PatchEvaluator,
    evaluator: PatchEvaluator,
    nominal: Refit,
    settings: DiagnosisSettings,
    report: Progress,
) -> Examined:
    """Score all candidates beside a nominal fit.

    Args:
        expected: with the sensor's errors as they are expected beforehand.
        evaluator: of the same model with those that are believed.
        nominal: its fit.
        settings: of the diagnosis.
        report: called with what is being done.
    """
    listed = candidates(evaluator.model.scene, settings.without, settings.fit)
    report(f'screening {len(listed)} candidates')
    judged = _judge(expected, evaluator, nominal, listed, settings.margin)
    return _without_local_outliers(judged, listed, settings.margin, report)


def _judge(
    expected: PatchEvaluator,
    evaluator: PatchEvaluator,
    nominal: Refit,
    listed: Sequence[Candidate],
    margin: float,
) -> Examined:
    is_moving = any(
        observation.instant is not None for observation in evaluator.model.observations
    )
    scores = screen(evaluator, nominal.coordinates, listed)
    disagreement = measure_disagreement(
        nominal, scores, margin, is_moving=is_moving, is_measured=evaluator.is_measured
    )
    return Examined(evaluator, nominal, scores, disagreement, expected)


def _without_local_outliers(
    judged: Examined, listed: Sequence[Candidate], margin: float, report: Progress
) -> Examined:
    """Leave out what is off in one place only, as long as the rest is said to be off, too."""
    outliers: list[LocalOutlier] = []
    while judged.disagreement.is_worth_naming and len(outliers) < _MOST_OUTLIERS:
        found = find_local_outlier(judged.evaluator, judged.nominal)
        if found is None:
            break
        outliers.append(found)
        report(found.sentence)
        evaluator = judged.evaluator.without(judged.evaluator.left_out | found.patches)
        nominal = fit_patches(evaluator, judged.nominal.coordinates)
        judged = _judge(judged.expected, evaluator, nominal, listed, margin)
    return replace(judged, outliers=tuple(outliers))
